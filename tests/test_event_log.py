import pytest

from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import KEPT, NOT_BOOTED, EventLog


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def log(clock):
    """Of a node that boots after a second and is started after another."""
    log = EventLog(clock)
    for state in ("PRE-OPERATIONAL", "OPERATIONAL"):
        clock.advance(1.0)
        log.add_state(state)
    clock.advance(1.0)
    return log


@pytest.mark.parametrize(
    ("time", "states"),
    [
        (0.0, {NOT_BOOTED}),
        (1.0, {"PRE-OPERATIONAL"}),
        (1.000001, {"PRE-OPERATIONAL"}),
        (1.999999, {"PRE-OPERATIONAL"}),
        (2.0, {"PRE-OPERATIONAL", "OPERATIONAL"}),
        (0.1 + 0.2 + 1.7, {"PRE-OPERATIONAL", "OPERATIONAL"}),
        (9.0, {"OPERATIONAL"}),
    ],
)
def test_a_moment_has_the_state_before_and_those_that_were_entered_in_it(log, time, states):
    assert log.states(time) == states


def test_states_that_are_too_long_ago_are_unknown(log, clock):
    for _ in range(KEPT):
        log.add_state("STOPPED")
    assert log.states(2.5) == set()
    assert log.states(clock.now) == {"STOPPED"}


def test_an_entry_has_its_time_its_frame_and_its_words(log):
    log.add_refusal(Frame(0x585, b"\x80"), ValueError("too much"), (0x2010, 0))
    log.add_strike(Frame(0x705, b"\x05"), "heartbeat_late")
    assert log.refusals[-1] == (3.0, "585#80", "too much", (0x2010, 0))
    assert log.strikes[-1] == (3.0, "705#05", "heartbeat_late", None)
