from itertools import product

import pytest

from canopen_twins.devices.topcon.model.states import TRANSITIONS, Mode, StageEvent, StageState

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
    assert (stage.warning, stage.state, stage.running) == (True, StageState.WARN, True)
    stage.reset()
    assert (stage.warning, stage.state) == (True, StageState.WARN)
    for name, value in gone.items():
        setattr(stage, name, value)
    stage.step(1.0)
    assert stage.warning
    stage.reset()
    assert (stage.warning, stage.state, stage.errors) == (False, StageState.RUN, ())
    assert stage.voltage == pytest.approx(200, rel=1e-4)  # never interrupted


@pytest.mark.spec("A-53")
def test_a_warning_outlives_stop_run_and_errors(running):
    stage = running(parts=CV)
    stage.warn()
    assert stage.state is StageState.WARN
    stage.stop()
    assert (stage.warning, stage.state) == (True, StageState.READY)
    stage.run()
    assert stage.state is StageState.WARN
    stage.trip(0x23)
    assert (stage.warning, stage.state) == (True, StageState.ERROR)
    stage.reset()
    assert (stage.warning, stage.state) == (False, StageState.READY)


@pytest.mark.spec("T-180")
@pytest.mark.parametrize("state", StageState)
def test_the_output_is_on_in_run_and_warn_only(power_on, state):
    stage = power_on(parts=CV)
    stage.state = state
    stage.step(0.001)
    assert stage.running is (state in (StageState.RUN, StageState.WARN))
    assert (stage.mode is Mode.OFF) is (not stage.running)


def test_mode_is_known_from_the_moment_of_run(power_on):
    stage = power_on(parts=CV)
    assert stage.mode is Mode.OFF
    stage.run()
    assert stage.mode is Mode.VOLTAGE


@pytest.mark.parametrize(("state", "event"), list(product(StageState, StageEvent)))
def test_every_state_trips_and_none_starts_but_ready(state, event):
    after = TRANSITIONS[state].get(event, state)
    if event is StageEvent.TRIP:
        assert after is StageState.ERROR
    if after is StageState.RUN and state is not StageState.RUN:
        assert (state, event) in [
            (StageState.READY, StageEvent.RUN),
            (StageState.WARN, StageEvent.CLEAR),
        ]


def test_a_unit_is_ready_after_its_boot_time(power_on):
    stage = power_on(parts=CV, boot_time=2.0)
    stage.run()
    stage.supplies = {"24V": 20.0}  # nobody is watching yet
    stage.step(1.999)
    assert (stage.state, stage.running, stage.errors) == (StageState.POWERUP, False, ())
    stage.supplies = {}
    stage.step(0.001)
    assert stage.state is StageState.READY
    stage.run()
    assert stage.running


def test_a_sleeping_unit_wakes_at_the_end_of_its_boot_time(power_on):
    stage = power_on(boot_time=2.0)
    stage.step(0.001)
    assert stage.rest == pytest.approx(1.999)
    stage.step(10.0)
    assert stage.state is StageState.READY
