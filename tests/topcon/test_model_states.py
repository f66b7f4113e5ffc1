from itertools import product

import pytest

from canopen_twins.devices.topcon.model import Mode, State
from canopen_twins.devices.topcon.model.modes import TRANSITIONS, Event

CV = (2000, 4000, 4000, 0)


@pytest.mark.spec("A-53")
@pytest.mark.parametrize(
    ("cause", "gone"),
    [
        ({"mains": 350.0}, {"mains": 400.0}),
        ({"mains": 440.0}, {"mains": 400.0}),
        ({"overvoltage_warning": 150.0}, {"overvoltage_warning": 250.0}),
        ({"overcurrent_warning": 15.0}, {"overcurrent_warning": 25.0}),
    ],
)
def test_a_warning_stays_until_a_reset_without_its_cause(running, cause, gone):
    stage = running(load="resistor 10", parts=CV)
    assert not stage.warning
    for name, value in cause.items():
        setattr(stage, name, value)
    stage.step(0.001)
    assert (stage.warning, stage.state, stage.running) == (True, State.WARN, True)
    stage.reset()
    assert (stage.warning, stage.state) == (True, State.WARN)
    for name, value in gone.items():
        setattr(stage, name, value)
    stage.step(1.0)
    assert stage.warning
    stage.reset()
    assert (stage.warning, stage.state, stage.errors) == (False, State.RUN, ())
    assert stage.voltage == pytest.approx(200, rel=1e-4)  # never interrupted


@pytest.mark.spec("A-53")
def test_a_warning_outlives_stop_run_and_errors(running):
    stage = running(parts=CV)
    stage.warn()
    assert stage.state is State.WARN
    stage.stop()
    assert (stage.warning, stage.state) == (True, State.READY)
    stage.run()
    assert stage.state is State.WARN
    stage.trip(0x23)
    assert (stage.warning, stage.state) == (True, State.ERROR)
    stage.reset()
    assert (stage.warning, stage.state) == (False, State.READY)


@pytest.mark.spec("T-180")
@pytest.mark.parametrize("state", State)
def test_the_output_is_on_in_run_and_warn_only(power_on, state):
    stage = power_on(parts=CV)
    stage.state = state
    stage.step(0.001)
    assert stage.running is (state in (State.RUN, State.WARN))
    assert (stage.mode is Mode.OFF) is (not stage.running)


def test_mode_is_known_from_the_moment_of_run(power_on):
    stage = power_on(parts=CV)
    assert stage.mode is Mode.OFF
    stage.run()
    assert stage.mode is Mode.VOLTAGE


@pytest.mark.parametrize(("state", "event"), list(product(State, Event)))
def test_every_state_trips_and_none_starts_but_ready(state, event):
    after = TRANSITIONS[state].get(event, state)
    if event is Event.TRIP:
        assert after is State.ERROR
    if after is State.RUN and state is not State.RUN:
        assert (state, event) in [(State.READY, Event.RUN), (State.WARN, Event.CLEAR)]


def test_a_unit_is_ready_after_its_boot_time(power_on):
    stage = power_on(parts=CV, boot_time=2.0)
    stage.run()
    stage.supply_24v = 20.0  # nobody is watching yet
    stage.step(1.999)
    assert (stage.state, stage.running, stage.errors) == (State.POWERUP, False, ())
    stage.supply_24v = 24.0
    stage.step(0.001)
    assert stage.state is State.READY
    stage.run()
    assert stage.running


def test_a_sleeping_unit_wakes_at_the_end_of_its_boot_time(power_on):
    stage = power_on(boot_time=2.0)
    stage.step(0.001)
    assert stage.rest == pytest.approx(1.999)
    stage.step(10.0)
    assert stage.state is State.READY
