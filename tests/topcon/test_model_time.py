"""Reference cases in time, for three lengths of the internal step."""

import pytest

from canopen_twins.devices.topcon.model.loads import Short
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.states import Mode, StageState

FULL = (4000, 4000, 4000, 0)


class Half(OutputStage):
    tick = 0.0005


class Tenth(OutputStage):
    tick = 0.0001


KINDS = pytest.mark.parametrize("kind", [OutputStage, Half, Tenth])


def time_until(stage, happened, limit=1.0):
    """Seconds from now until a condition is true, stepping tick by tick."""
    start = stage.ticks
    while not happened(stage):
        assert stage.ticks - start < limit / stage.tick
        stage.step(stage.tick)
    return (stage.ticks - start) * stage.tick


@KINDS
def test_the_start_slope_takes_100_ms_to_nominal_voltage(power_on, kind):
    stage = power_on(load="resistor 10", parts=FULL, kind=kind)
    stage.run()
    assert time_until(stage, lambda it: round(it.voltage * 10) >= 2000) == pytest.approx(0.050)
    assert time_until(stage, lambda it: round(it.voltage * 10) >= 3999) == pytest.approx(0.050)


@pytest.mark.spec("T-190", "A-54")
@pytest.mark.parametrize(
    ("kind", "after", "peak"), [(OutputStage, 51.0, 204), (Half, 50.5, 202), (Tenth, 50.5, 202)]
)
def test_overvoltage_trips_on_the_rising_edge(power_on, kind, after, peak):
    stage = power_on(parts=(3000, 4000, 4000, 0), kind=kind)
    stage.overvoltage_level = 200.0
    stage.run()
    assert time_until(stage, lambda it: it.errors) == pytest.approx(after / 1000)
    assert stage.errors == (0x30,)
    assert stage.state is StageState.ERROR
    assert stage.voltage == pytest.approx(peak, abs=0.1)
    assert not stage.running


@pytest.mark.spec("T-191", "A-55")
@pytest.mark.parametrize(("kind", "after"), [(OutputStage, 67.0), (Half, 67.5), (Tenth, 67.5)])
def test_overcurrent_trips_on_the_rising_edge(power_on, kind, after):
    stage = power_on(load="resistor 5", parts=FULL, kind=kind)
    stage.overcurrent_level = 50.0
    stage.run()
    assert time_until(stage, lambda it: it.errors) == pytest.approx(after / 1000)
    assert stage.errors == (0x21,)


@KINDS
def test_an_open_output_falls_with_its_bleeder_after_stop(power_on, kind):
    stage = power_on(parts=(2000, 4000, 4000, 0), kind=kind)
    stage.run()
    stage.step(0.5)
    stage.stop()
    falling = time_until(stage, lambda it: it.voltage <= 200 * 0.36788, limit=2)
    assert falling == pytest.approx(1.0, abs=0.0012)


def test_a_sudden_short_is_a_capacitor_peak_and_then_the_current_limit(running):
    stage = running(parts=(4000, 1000, 4000, 0))
    stage.load = Short()
    currents = []
    for _ in range(4):
        stage.step(stage.tick)
        currents.append(stage.current)
    assert currents == pytest.approx([224.8, 25.2, 25.0, 25.0], abs=0.05)
    stage.step(1.0)
    assert stage.errors == ()
    assert stage.mode is Mode.CURRENT


@pytest.mark.spec("T-192")
@KINDS
def test_i2t_trips_when_its_store_is_full(power_on, kind):
    limits = {"i2t_current": 50.0, "i2t_limit": 3750.0}
    stage = power_on(load="resistor 4", parts=FULL, figures=limits, kind=kind)
    stage.run()
    warned = time_until(stage, lambda it: it.warning)
    tripped = warned + time_until(stage, lambda it: it.errors)
    assert tripped == pytest.approx(0.755, abs=0.002)
    assert warned == pytest.approx(tripped - 1875 / (89.4427**2 - 50**2), abs=0.002)
    assert stage.errors == (0x20,)


@pytest.mark.parametrize(
    ("ambient", "warning_at", "temperature", "parts"),
    [(25.0, None, 67.5, 4000), (45.0, 174, 86.3, None), (70.0, 27, 92.9, 2856)],
)
@pytest.mark.spec("A-53")
def test_fifteen_minutes_at_full_power(power_on, ambient, warning_at, temperature, parts):
    stage = power_on(load="resistor 5", parts=FULL, ambient=ambient)
    stage.run()
    warned = []
    for second in range(1, 901):
        stage.step(1.0)
        if stage.warning:
            warned.append(second)
    assert (warned[0] if warned else None) == warning_at
    assert stage.temperature == pytest.approx(temperature, abs=0.1)
    assert stage.errors == ()
    if parts:
        assert stage.voltage * 10 == pytest.approx(parts, abs=2)
