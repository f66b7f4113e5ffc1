import pytest

from canopen_twins import Bench
from canopen_twins.devices.topcon.model.protections import above_derated_sink

from .bus import emcy, run, state_of_output

BATTERY = "battery 350 V 0.1 ohm"


@pytest.fixture
def sinking(unit_file):
    """A Q4 unit that takes all it can out of a battery; the warning comes from nothing."""

    def sinking(sink=50.0, **figures):
        file = unit_file(sink_current=sink, **figures)
        bench = Bench("topcon", node_id=5, unit="MINE", unit_file=file, load=BATTERY)
        run(bench, voltage=3000)
        return bench

    return sinking


@pytest.mark.spec("T-180")
def test_a_sink_limit_that_holds_is_current_control(sinking):
    bench = sinking()
    bench.run(1.0)
    assert bench.sdo["Actual current"].raw == -2000
    assert state_of_output(bench) == 0x0005
    bench.sdo["Voltage reference"].raw = 3490
    bench.run(1.0)
    assert bench.sdo["Actual current"].raw == pytest.approx(-400, abs=2)
    assert state_of_output(bench) == 0x0003


@pytest.mark.spec("T-191", "A-83")
def test_a_current_taken_in_above_its_level_is_the_q4_overcurrent(sinking):
    bench = sinking()
    bench.run(1.0)
    bench.sdo["Overcurrent level"].raw = 2000
    assert bench.run(1.0) == []
    bench.sdo["Overcurrent level"].raw = 1999
    assert bench.run(0.004) == []
    assert bench.run(0.002) == [emcy(0x2300, 0x03, 0x29)]
    assert state_of_output(bench) == 0x8000


@pytest.mark.spec("T-191")
def test_a_one_quadrant_unit_has_no_q4_overcurrent(topcon):
    topcon.set(load=BATTERY)
    run(topcon, voltage=3000)
    topcon.sdo["Overcurrent level"].raw = 0
    assert topcon.run(1.0) == []


@pytest.mark.spec("T-192", "A-83")
def test_a_unit_at_its_own_sink_limit_never_fills_its_i2t_store():
    bench = Bench("topcon", node_id=5, unit="TCP-32-400-IBC", load=BATTERY)
    run(bench, voltage=3000)
    assert bench.run(3600.0) == []
    assert bench.sdo["Actual current"].raw == -4000
    assert state_of_output(bench) & 0x8005 == 0x0005


@pytest.mark.spec("A-84")
def test_a_hot_unit_takes_in_less_as_it_gives_less(sinking):
    bench = sinking(sink=100.0)
    bench.set(ambient=65)
    assert bench.run(3600.0) == []
    assert -4000 < bench.sdo["Actual current"].raw < -2000
    assert state_of_output(bench) & 0x8005 == 0x0005


@pytest.mark.spec("T-192", "A-83")
def test_a_current_taken_in_over_the_derated_maximum_trips(running):
    q4 = {"sink_current": 100.0}
    stage = running(load="battery 350 0.1", parts=(3000, 4000, 4000, 0), figures=q4)
    stage.heat.temperature = 89.0
    stage.circuit.current = -100.0
    assert stage.derated_maximum < 75
    assert above_derated_sink(stage)
    stage.stop()
    assert not above_derated_sink(stage)
