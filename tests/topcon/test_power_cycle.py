from math import exp

import pytest

from canopen_twins import Bench

from .bus import emcy, run, state_of_output


def cycle(bench, seconds):
    """The supply goes and comes back."""
    bench.power_off()
    bench.run(seconds)
    bench.power_on()


@pytest.mark.spec("A-76")
@pytest.mark.parametrize("seconds", [0.0, 1.0, 3600.0])
def test_a_battery_is_there_at_power_on_without_an_inrush(seconds):
    bench = Bench("topcon", node_id=5, load="battery 350 V 0.1 ohm")
    bench.run(1.0)
    cycle(bench, seconds)
    for _ in range(5):
        assert bench.sdo["Actual voltage"].raw == 3500
        assert bench.sdo["Actual current"].raw == -7  # into the bleeder
        bench.run(0.001)


@pytest.mark.spec("A-76")
@pytest.mark.parametrize("seconds", [0.02, 0.5, 5.0])
def test_an_open_output_falls_with_its_bleeder_whether_there_is_supply_or_not(topcon, seconds):
    run(topcon, voltage=3500)
    topcon.run(1.0)
    cycle(topcon, seconds)
    assert topcon.sdo["Actual voltage"].raw == pytest.approx(3500 * exp(-seconds), abs=3)
    assert state_of_output(topcon) == 0


@pytest.mark.spec("A-76")
def test_the_current_in_a_winding_goes_on_without_supply():
    bench = Bench("topcon", node_id=5, load="inductor 1 ohm 1 H")
    run(bench, voltage=200)  # 20 V
    bench.run(10.0)
    assert bench.sdo["Actual current"].raw == 800
    cycle(bench, 0.5)
    assert bench.sdo["Actual current"].raw == pytest.approx(800 * exp(-0.5), abs=3)


@pytest.mark.spec("A-76", "A-84")
def test_a_hot_unit_cools_down_and_is_not_cold_when_supply_is_back():
    bench = Bench("topcon", node_id=5, load="resistor 5 ohm")
    run(bench)
    bench.run(900.0)
    hot = bench.device.report["heat sink [degC]"]
    assert hot > 60
    bench.power_off()
    bench.run(99.6)  # one time constant
    assert bench.device.report["heat sink [degC]"] == pytest.approx(
        25 + (hot - 25) / 2.718, abs=0.1
    )
    bench.power_on()
    assert bench.device.report["heat sink [degC]"] > 35


@pytest.mark.spec("A-76")
def test_a_load_that_is_changed_while_there_is_no_supply(topcon):
    run(topcon, voltage=3500)
    topcon.run(1.0)
    topcon.power_off()
    topcon.set(load="short")
    topcon.run(0.02)
    assert topcon.device.report["voltage [V]"] == 0
    topcon.set(load="battery 200 V 0.1 ohm")
    topcon.run(0.1)
    topcon.power_on()
    assert topcon.sdo["Actual voltage"].raw == 2000


@pytest.mark.spec("A-57", "A-76")
def test_an_output_above_its_level_trips_as_soon_as_there_is_supply():
    bench = Bench("topcon", node_id=5, load="battery 350 V 0.1 ohm", power_on_overvoltage=3000)
    bench.run(0.1)
    cycle(bench, 10.0)
    before = len(bench.sent)
    bench.run(0.01)
    assert bench.sent[before:] == [emcy(0x3300, 0x05, 0x30)]


@pytest.mark.spec("A-76")
def test_how_often_somebody_looks_changes_nothing():
    def after(pauses):
        bench = Bench("topcon", node_id=5, load="battery 350 V 0.1 ohm 5Ah soc=0.1")
        run(bench, current=2000)
        bench.run(60.0)
        bench.power_off()
        for pause in pauses:
            bench.run(pause)
            assert bench.device.report["mode"] == "OFF"
        bench.power_on()
        return bench.device.report

    once, often = after([100.0]), after([0.001, 0.5, 9.499, 90.0])
    assert once["voltage [V]"] == pytest.approx(often["voltage [V]"], abs=0.001)
    assert once["heat sink [degC]"] == often["heat sink [degC]"]
