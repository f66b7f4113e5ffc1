import pytest

from canopen_twins.devices.charger.model.load import OPEN, SHORT, Resistor
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource, ReleaseState
from canopen_twins.devices.charger.model.sparks import Counter, Counting, Sparks
from canopen_twins.devices.charger.model.types import TYPES

SE, SW, WE, WW = Counter


def counts(charger):
    return [charger.charging.sparks.counts[counter] for counter in Counter]


def strike(charger, steepness, times=1):
    """Sparks of so many mA/ms, far enough from each other."""
    for _ in range(times):
        charger.spark(steepness * 0.008)
        charger.step(0.05)


@pytest.mark.spec("C-173")
@pytest.mark.parametrize(
    ("steepness", "counted"),
    [
        (0.12, [0, 0, 0, 0]),
        (0.125, [0, 0, 0, 0]),
        (0.13, [0, 0, 0, 1]),
        (0.17, [0, 0, 1, 0]),
        (0.21, [0, 1, 0, 0]),
        (0.25, [0, 1, 0, 0]),
        (0.26, [1, 0, 0, 0]),
    ],
)
def test_a_spark_counts_where_it_first_exceeds_a_level(running, steepness, counted):
    strike(running, steepness)
    assert counts(running) == counted


@pytest.mark.spec("C-173")
@pytest.mark.parametrize(
    ("counting", "counted"),
    [
        (Counting.EXCLUSIVE, [1, 0, 0, 0]),
        (Counting.PER_CLASS, [1, 0, 1, 0]),
        (Counting.CUMULATIVE, [1, 1, 1, 1]),
    ],
)
def test_one_spark_may_be_read_into_several_counters(make, switch_on, counting, counted):
    charger = make(voltage_setpoint=20000, sparks=Sparks(counting))
    switch_on(charger)
    strike(charger, 0.26)
    assert counts(charger) == counted


@pytest.mark.spec("C-173")
def test_a_slow_rise_is_less_steep(running):
    running.spark(0.0026, rise_time=0.008)
    running.step(0.1)
    running.spark(0.0026, rise_time=0.020)  # 0.13 mA/ms
    assert counts(running) == [1, 0, 0, 1]


@pytest.mark.spec("C-173")
def test_nothing_counts_without_high_voltage_and_everything_while_a_ramp_runs(charger):
    strike(charger, 0.26)
    assert counts(charger) == [0, 0, 0, 0]
    charger.write(Parameter.VOLTAGE_SETPOINT, 20000)
    charger.grant(ReleaseSource.CANOPEN)
    strike(charger, 0.26)
    assert counts(charger) == [1, 0, 0, 0]


@pytest.mark.spec("C-173", "C-174")
def test_a_master_that_trims_all_the_time_does_not_blind_the_detector(running, active):
    for trim in range(10):
        running.write(Parameter.VOLTAGE_SETPOINT, 20001 + trim)
        strike(running, 0.26)
        running.step(0.15)
    assert counts(running) == [10, 0, 0, 0]
    assert active(running) == [("ERROR", "strong_sparks")]


@pytest.mark.spec("C-173")
@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
@pytest.mark.parametrize("mode", [0, 1])
def test_what_a_ramp_makes_of_the_current_is_no_spark(make, switch_on, kind, mode):
    charger = make(
        kind,
        ramp_time=100,
        mode=kind.lowest_mode + mode,
        voltage_setpoint=kind.maximum_voltage,
        current_setpoint=kind.maximum_current,
        weak_sparks=10,
        limiter_warning=0,
    )
    switch_on(charger)
    charger.write(Parameter.CURRENT_SETPOINT, kind.minimum_current)
    charger.step(0.5)
    charger.write(Parameter.CURRENT_SETPOINT, kind.maximum_current)
    charger.step(0.5)
    if mode:
        charger.write(Parameter.MODE, kind.lowest_mode)
        charger.step(0.5)
    assert charger.charging.output.power > 0.5 * kind.power
    assert counts(charger) == [0, 0, 0, 0]


@pytest.mark.spec("C-173")
@pytest.mark.parametrize(
    ("electrode", "counted"),
    [
        (SHORT, [1, 0, 0, 0]),  # 2000 to 5000 uA
        (Resistor(20e3 / 4444e-6), [1, 0, 0, 0]),  # 2444 uA in 8 ms are 0.3055 mA/ms
        (Resistor(20e3 / 3700e-6), [0, 1, 0, 0]),  # 0.2125 mA/ms
        (Resistor(20e3 / 3400e-6), [0, 0, 1, 0]),  # 0.175 mA/ms
        (Resistor(20e3 / 3100e-6), [0, 0, 0, 1]),  # 0.1375 mA/ms
        (Resistor(20e3 / 2900e-6), [0, 0, 0, 0]),
        (OPEN, [0, 0, 0, 0]),  # less is no spark
    ],
)
@pytest.mark.parametrize("ramping", [False, True])
def test_a_load_that_takes_more_all_of_a_sudden_is_a_spark(running, electrode, counted, ramping):
    if ramping:
        running.write(Parameter.VOLTAGE_SETPOINT, 20001)
    running.surround(electrode=electrode)
    running.step(1.0)
    assert counts(running) == counted


def test_a_counted_spark_blinds_the_detector_for_20_ms(running):
    running.spark(0.0026)
    running.step(0.01)
    running.spark(0.0026)
    assert counts(running) == [1, 0, 0, 0]
    running.step(0.01)
    running.spark(0.0026)
    assert counts(running) == [2, 0, 0, 0]


def test_a_spark_shows_in_current_and_voltage_and_passes(running):
    before = running.charging.output.current
    running.spark(0.002)
    assert running.charging.output.current == pytest.approx(before + 0.002)
    assert running.charging.output.voltage == pytest.approx(20000 - 0.002 * 0.008 / 2e-9)
    running.step(0.3)
    assert running.charging.output.voltage == 20000
    assert running.charging.output.current == before


@pytest.mark.spec("C-174")
def test_ten_strong_sparks_are_an_error_that_switches_off(running, active):
    strike(running, 0.26, times=9)
    assert active(running) == []
    assert running.charging_active
    strike(running, 0.26)
    assert counts(running) == [10, 0, 0, 0]
    assert active(running) == [("ERROR", "strong_sparks")]
    assert running.release.state is ReleaseState.FAULT


@pytest.mark.spec("C-172", "C-174")
@pytest.mark.parametrize(
    ("steepness", "message"),
    [
        (0.26, ("ERROR", "strong_sparks")),
        (0.21, ("WARNING", "strong_sparks")),
        (0.17, ("ERROR", "weak_sparks")),
        (0.13, ("WARNING", "weak_sparks")),
    ],
)
def test_each_counter_has_its_own_message_at_the_limit(running, active, steepness, message):
    running.write(Parameter.SPARKS_LIMIT, 3)
    strike(running, steepness, times=2)
    assert active(running) == []
    strike(running, steepness)
    assert active(running) == [message]


@pytest.mark.spec("C-174")
def test_a_limit_of_zero_counts_without_a_message(running, active):
    running.write(Parameter.SPARKS_LIMIT, 0)
    strike(running, 0.26, times=20)
    assert counts(running) == [20, 0, 0, 0]
    assert active(running) == []


@pytest.mark.spec("C-175")
def test_a_counter_stops_at_65535(running):
    running.charging.sparks.counts[SE] = 0xFFFF
    running.write(Parameter.SPARKS_LIMIT, 0)
    strike(running, 0.26)
    assert counts(running)[0] == 0xFFFF


@pytest.mark.spec("C-175")
def test_clearing_a_message_resets_its_counter_alone(running):
    running.write(Parameter.SPARKS_LIMIT, 2)
    strike(running, 0.21, times=2)
    strike(running, 0.13)
    warning = running.messages.active[0]
    running.clear(warning.severity, warning.number)
    assert running.messages.active == []
    assert counts(running) == [0, 0, 0, 1]


@pytest.mark.spec("C-175")
def test_counters_survive_switching_off_but_no_restart(running):
    strike(running, 0.13)
    running.revoke(ReleaseSource.CANOPEN)
    running.step(1.0)
    assert counts(running) == [0, 0, 0, 1]
    running.restart({})
    assert counts(running) == [0, 0, 0, 0]


def test_the_voltage_recovers_within_some_20_ms(running):
    running.spark(0.002)
    running.step(0.02)
    assert 20000 - running.charging.output.voltage == pytest.approx(8000 / 2.718282, rel=1e-4)
    running.step(0.18)
    assert running.charging.output.voltage == pytest.approx(20000, abs=0.5)


def test_a_slow_spark_shows_for_its_rise_time(running):
    before = running.charging.output.current
    running.spark(1e-6, rise_time=2.0)
    running.step(1.99)
    assert running.charging.output.current == pytest.approx(before + 1e-6)
    running.step(0.01)
    assert running.charging.output.current == before


@pytest.mark.parametrize(("gap", "counted"), [(0.011, 1), (0.019, 1), (0.02, 2)])
@pytest.mark.parametrize("phase", [0.0, 0.003, 0.009])
def test_the_dead_time_is_20_ms_wherever_in_a_tick_a_spark_strikes(on, phase, gap, counted):
    on.run(phase)
    on.inject("spark", slope=0.26)
    on.run(gap)
    on.inject("spark", slope=0.26)
    assert on.sdo[0x2001][0x08].raw == counted
