import pytest

from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import KEPT, UNBORN, Diary


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def diary(clock):
    """Of a node that boots after a second and is started after another."""
    diary = Diary(clock)
    for state in ("PRE-OPERATIONAL", "OPERATIONAL"):
        clock.advance(1.0)
        diary.enter(state)
    clock.advance(1.0)
    return diary


@pytest.mark.parametrize(
    ("time", "states"),
    [
        (0.0, {UNBORN}),
        (1.0, {"PRE-OPERATIONAL"}),
        (1.000001, {"PRE-OPERATIONAL"}),
        (1.999999, {"PRE-OPERATIONAL"}),
        (2.0, {"PRE-OPERATIONAL", "OPERATIONAL"}),
        (0.1 + 0.2 + 1.7, {"PRE-OPERATIONAL", "OPERATIONAL"}),
        (9.0, {"OPERATIONAL"}),
    ],
)
def test_a_moment_has_the_state_before_and_those_that_were_entered_in_it(diary, time, states):
    assert diary.states(time) == states


def test_states_that_are_too_long_ago_are_unknown(diary, clock):
    for _ in range(KEPT):
        diary.enter("STOPPED")
    assert diary.states(2.5) == set()
    assert diary.states(clock.now) == {"STOPPED"}


def test_a_note_has_its_time_its_frame_and_its_words(diary):
    diary.refuse(Frame(0x585, b"\x80"), ValueError("too much"), (0x2010, 0))
    diary.strike(Frame(0x705, b"\x05"), "heartbeat_late")
    assert diary.refusals[-1] == (3.0, "585#80", "too much", (0x2010, 0))
    assert diary.strikes[-1] == (3.0, "705#05", "heartbeat_late", None)
