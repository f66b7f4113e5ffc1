from math import floor
from time import perf_counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canopen_twins import Bench
from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.discharging import Bars
from canopen_twins.devices.charger.model.load import SHORT
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.sparks import Storm
from canopen_twins.devices.charger.model.types import PCSC, Build, Variant
from canopen_twins.devices.charger.object_table import factory

TICK = 0.01
ACTS = {
    "nothing": lambda charger: None,
    "release": lambda charger: charger.grant(ReleaseSource.CANOPEN),
    "lock": lambda charger: charger.revoke(ReleaseSource.CANOPEN),
    "timeout": lambda charger: charger.write(Parameter.RELEASE_TIMEOUT, 4130),
    "20 kV": lambda charger: charger.write(Parameter.VOLTAGE_SETPOINT, 20000),
    "30 kV": lambda charger: charger.write(Parameter.VOLTAGE_SETPOINT, 30000),
    "1 mA": lambda charger: charger.write(Parameter.CURRENT_SETPOINT, 1000),
    "I-Const": lambda charger: charger.write(Parameter.MODE, 4),
    "ramp": lambda charger: charger.write(Parameter.RAMP_TIME, 1234),
    "calibrate": lambda charger: charger.write(Parameter.POLLUTION_DETECTION, 2),
    "discharge": lambda charger: charger.write(Parameter.MODE_DISCHARGING, 1),
    "spark": lambda charger: charger.spark(0.0026, 0.03),
    "slow spark": lambda charger: charger.spark(1e-6, 3.0),
    "storm": lambda charger: charger.surround(storm=Storm(rate=0.3)),
    "short": lambda charger: charger.surround(electrode=SHORT),
    "dirt": lambda charger: charger.surround(active=0.3),
    "deep sag": lambda charger: charger.surround(supply_voltage=19.3),
    "overheated": lambda charger: charger.surround(heat={"inside": 60.0}),
    "sag": lambda charger: charger.surround(supply_voltage=20.3),
    "hot": lambda charger: charger.surround(heat={"power_stage": 47.0}),
    "open": lambda charger: charger.surround(hardware_release=False),
    "closed": lambda charger: charger.surround(hardware_release=True),
}


def shown(charger):
    """What can be read of a charger, as finely as it can be read."""
    charging, output = charger.charging, charger.charging.output
    return {
        "release": charger.release.state,
        "output": (output.voltage, output.current, output.limiter),
        "bar": (charging.resistance, charging.pollution, charging.calibrating),
        "sparks": dict(charging.sparks.counts),
        "discharging": (charger.discharging.now, charger.dirt),
        "power": (charger.derating.charging, charger.derating.discharging),
        "supply": charger.supply,
        "degrees": {k: floor(v) for k, v in charger.heating.at(charger.now).items()},
        "messages": list(charger.messages.active),
        "parameters": {name: charger.parameters[name] for name in Parameter},
    }


def exactly(charger):
    unseen = {"temperatures": charger.heating.at(charger.now), "ticks": vars(charger.hours)}
    return shown(charger) | unseen


story = st.lists(st.tuples(st.sampled_from(sorted(ACTS)), st.integers(1, 200)), max_size=6)


def twin(catalogue):
    values = factory(PCSC) | {Parameter.RELEASE_MODE: 8, Parameter.SOFTWARE_RELEASE_DISCHARGING: 0}
    return Charger(Build(PCSC, Variant.A), values, catalogue)


@given(story=story)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_a_long_step_is_exactly_many_short_ones(story, catalogue):
    long, short = twin(catalogue), twin(catalogue)
    for act, ticks in story:
        ACTS[act](long)
        ACTS[act](short)
        long.step(ticks * TICK)
        for _ in range(ticks):
            short.step(TICK)
        assert exactly(long) == exactly(short), act


@given(story=story)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_a_charger_at_rest_shows_nothing_new_before_its_rest_is_over(story, catalogue):
    charger = twin(catalogue)
    for act, ticks in story:
        ACTS[act](charger)
        charger.step(ticks * TICK)
        rest, before = charger.rest, shown(charger)
        if rest:
            charger.step(rest - TICK)
            assert shown(charger) == before, act


class Forgetful(set):
    """For a charger that judges itself whenever its discharging moves."""

    def add(self, point):
        pass


WATCHED = ACTS | {
    "watch": lambda charger: charger.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 1),
    "learn": lambda charger: charger.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 2),
    "dirt on a bar": lambda charger: charger.surround(bars=Bars(power=(2.0, 0.3))),
    "clean bars": lambda charger: charger.surround(bars=Bars()),
    "little power": lambda charger: charger.surround(supply_voltage=18.1),
    "almost hot": lambda charger: charger.surround(heat={"discharging": 44.5}),
    "as ever": lambda charger: charger.surround(supply_voltage=24.0, heat={}),
}


@given(story=st.lists(st.tuples(st.sampled_from(sorted(WATCHED)), st.integers(1, 200_000))))
@settings(max_examples=12, deadline=None, derandomize=True)
def test_what_a_charger_does_not_judge_again_would_tell_nothing(story, catalogue):
    charger, careful = twin(catalogue), twin(catalogue)
    careful._calm = Forgetful()
    for each in (charger, careful):
        each.write(Parameter.FREQUENCY_DISCHARGING, 5)
        WATCHED["discharge"](each)
        WATCHED["watch"](each)
    for act, ticks in [("nothing", 200_000), *story[:6]]:
        for each in (charger, careful):
            WATCHED[act](each)
            each.step(ticks * TICK)
        assert exactly(charger) == exactly(careful), act


@pytest.mark.parametrize("seconds", [0.005, 0.015, 1 / 3])
def test_a_step_is_a_whole_number_of_10_ms(charger, seconds):
    with pytest.raises(ValueError, match="whole multiple"):
        charger.step(seconds)


@pytest.mark.parametrize("variant", ["base", "A", "C"])
def test_an_idle_year_is_a_few_hours_of_its_memory_and_nothing_else(variant):
    bench = Bench("charger", variant=variant)
    bench.sdo[0x1017].raw = 0
    began = perf_counter()
    assert bench.run(365 * 86400.0) == []
    assert perf_counter() - began < 5
    assert [bench.sdo[0x2000][sub].raw for sub in (1, 2, 3, 4)] == [1, 0, 0, 0]


def test_a_charger_at_work_comes_to_rest(running):
    assert running.rest == 0
    running.step(3600.0)
    assert running.rest > 1


@pytest.mark.parametrize("act", sorted(set(ACTS) - {"nothing", "closed", "spark"}))
def test_whatever_is_done_ends_the_rest(running, act):
    running.step(3600.0)
    ACTS[act](running)
    assert running.rest == 0


@pytest.mark.parametrize("act", sorted(ACTS))
def test_a_long_step_over_an_event_is_exactly_many_short_ones(catalogue, act):
    long, short = twin(catalogue), twin(catalogue)
    for charger in (long, short):
        ACTS["20 kV"](charger)
        ACTS["release"](charger)
        charger.step(3600.0)
        ACTS["release"](charger)
        ACTS[act](charger)
    for ticks in (5, 95, 700):
        long.step(ticks * TICK)
        for _ in range(ticks):
            short.step(TICK)
        assert exactly(long) == exactly(short)


def by_its_rest(charger, until):
    """The ticks a charger needs when it is stepped only as often as it asks for."""
    begin = charger.now
    while not until(charger):
        charger.step(charger.rest or TICK)
    return charger.now - begin


def by_ticks(charger, until):
    """The ticks it needs when it is stepped at every one."""
    begin = charger.now
    while not until(charger):
        charger.step(TICK)
    return charger.now - begin


@pytest.mark.spec("C-139")
def test_a_release_timeout_ends_the_rest_to_the_tick(make):
    charger = make(release_timeout=60000)
    charger.grant(ReleaseSource.CANOPEN)
    assert by_its_rest(charger, lambda charger: not charger.release.software) == 6000


@pytest.mark.spec("C-178")
def test_a_calibration_ends_the_rest_to_the_tick(running):
    running.write(Parameter.POLLUTION_DETECTION, 2)
    assert by_its_rest(running, lambda charger: not charger.charging.calibrating) == 120_000


@pytest.mark.spec("C-198")
def test_a_calibration_of_the_discharging_ends_the_rest_to_the_tick(catalogue):
    charger = twin(catalogue)
    ACTS["discharge"](charger)
    charger.step(7.0)
    charger.write(Parameter.POLLUTION_DETECTION_DISCHARGING, 2)
    found = Parameter.NOMINAL_POWER_1
    assert by_its_rest(charger, lambda charger: charger.parameters[found]) == 6000


def dirty(make, switch_on):
    charger = make(voltage_setpoint=20000, pollution_detection=1, nominal_resistor=10_000_000)
    switch_on(charger, 7.0)
    ACTS["dirt"](charger)
    return charger


def short_circuited(make, switch_on):
    charger = make(voltage_setpoint=20000, ramp_time=10000, mode=4)
    ACTS["short"](charger)
    switch_on(charger, 0.0)
    return charger


def limited(make, switch_on):
    charger = make(voltage_setpoint=20000, current_setpoint=500, ramp_time=10000)
    switch_on(charger, 0.0)
    return charger


@pytest.mark.parametrize("story", [dirty, short_circuited, limited])
def test_a_message_that_takes_its_time_ends_the_rest_to_the_tick(make, switch_on, story):
    def is_told(charger):
        return charger.messages.active

    assert by_its_rest(story(make, switch_on), is_told) == by_ticks(story(make, switch_on), is_told)
