from math import isfinite

import pytest

from canopen_twins import Bench, devices

BOOT_TIME = 10.0  # seconds; some take their time


@pytest.fixture(params=devices.names())
def bench(request):
    """A bench with a device that has booted."""
    bench = Bench(request.param)
    bench.run(BOOT_TIME)
    return bench


def test_every_device_shows_something_and_every_curve_has_a_name_of_its_own(bench):
    labels = [curve.label for curve in bench.twin.node.device.chart.curves]
    assert labels
    assert len(set(labels)) == len(labels)


def test_every_curve_can_be_read_at_any_time(bench):
    device = bench.twin.node.device
    chart = device.chart
    for act in (lambda: None, bench.power_off, bench.power_on):
        act()
        values = [curve.actual() for curve in chart.curves]
        assert all(value is None or isfinite(value) for value in values)
        assert chart.band is None or chart.band().label


def test_a_chart_is_of_the_model_that_a_power_cycle_has_made():
    bench = Bench("topcon", load="open")
    bench.sdo["Voltage reference"].raw = 1000
    bench.power_off()
    bench.power_on()
    bench.sdo["Voltage reference"].raw = 2000
    voltage, *_ = bench.twin.node.device.chart.curves
    assert voltage.wanted() == 200.0


def test_the_output_of_a_topcon_is_shown_in_engineering_units():
    bench = Bench("topcon", load="resistor 2")
    chart = bench.twin.node.device.chart
    bench.sdo["Voltage reference"].raw = 1000  # parts of 4000
    bench.sdo["Current reference"].raw = 4000
    bench.sdo["Run command"].raw = 1
    bench.run(2)
    voltage, current, power = ((curve.actual(), curve.unit) for curve in chart.curves)
    assert voltage == (pytest.approx(100, rel=1e-3), "V")
    assert current == (pytest.approx(50, rel=1e-3), "A")
    assert power == (pytest.approx(5, rel=1e-3), "kW")
    assert chart.band().label == "run"


def test_a_charger_with_an_analog_setpoint_shows_that_one():
    bench = Bench("charger", kind="PCSC")
    voltage, *_ = bench.twin.node.device.chart.curves
    bench.sdo[0x2002][0x03].raw = 2
    bench.inject("analog", percent=50.0)
    assert voltage.wanted() == 15.0


def test_only_a_charger_that_discharges_shows_it():
    def labels(variant):
        device = devices.create("charger", variant=variant)
        return [curve.label for curve in device.chart.curves]

    assert "Discharging" in labels("A")
    assert "Discharging" not in labels("base")


def test_the_engine_of_a_gateway_is_shown_as_its_governor_drives_it():
    bench = Bench("gateway", config="gateway_plain.yaml", run=True, autostart=True)
    chart = bench.twin.node.device.chart
    speed, *_ = chart.curves
    assert (speed.actual(), speed.wanted()) == (0, None)
    bench.run(20)
    assert speed.actual() == pytest.approx(1500, abs=5)
    assert speed.wanted() == 1500
    assert chart.band().label == "running"
    bench.inject("overspeed")
    bench.run(0.1)
    assert chart.band().label == "overspeed stop"
