"""How a run ends: at its time, after an error, and with a cleanup whatever came of it."""

import pytest
from probe import Probe

from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.scenario import Kind, Player, play

CLEANUP = """\
cleanup:
  - {nmt: stop}
  - {after: 0.5, send: 777#}
"""


def test_cleanup_comes_when_the_last_step_and_its_window_are_over(played):
    frames, outcomes = played(f"- {{at: 1, expect: {{emcy: none, within: 1}}}}\n{CLEANUP}")
    assert frames[1:] == ["2 000#0205", "2.5 777#"]
    assert outcomes == ["PASS 2 none came"]


def test_cleanup_comes_at_once_after_an_error_and_the_rest_is_left_out(played):
    frames, outcomes = played(
        f"""\
- {{at: 0, expect: {{emcy: any, within: 5}}}}
- {{when: {{emcy: any}}, send: 111#}}
- {{at: 1, write: {{Refusing: 1}}}}
- {{at: 1, send: 222#}}
- {{at: 1, expect: {{emcy: none, within: 1}}}}
- {{after: 1, send: 333#, every: 0.1, times: 5}}
{CLEANUP}"""
    )
    assert [frame for frame in frames if "5#" not in frame] == ["1 000#0205", "1.5 777#"]
    assert outcomes == [
        "SKIP 1 left out after the error in line 6",
        "SKIP 1 left out after the error in line 6",
        "ERROR 1 Refusing is refused with 0x08000021 (local control)",
        "SKIP 1 left out after the error in line 6",
        "SKIP 1 left out after the error in line 6",
        "SKIP 1 left out after the error in line 6",
    ]


def test_an_error_ends_the_repetition_of_its_step(played):
    frames, outcomes = played("- {at: 1, write: {Refusing: 1}, every: 1, times: 5}\nduration: 9\n")
    assert len([frame for frame in frames if " 605#" in frame]) == 1
    assert outcomes == ["ERROR 1 Refusing is refused with 0x08000021 (local control)"]


def test_a_failure_ends_nothing(played):
    frames, outcomes = played(
        f"- {{at: 1, expect: {{emcy: any, within: 0}}}}\n- {{at: 2, send: 111#}}\n{CLEANUP}"
    )
    assert frames[1:] == ["2 111#", "2 000#0205", "2.5 777#"]
    assert outcomes == ["FAIL 1 none came"]


def test_an_error_in_the_cleanup_ends_nothing_either(played):
    frames, outcomes = played(
        """\
- {at: 1, send: 111#}
cleanup:
  - {write: {Refusing: 1}}
  - {nmt: start}
  - {expect: {heartbeat: any, within: 0.1}}
"""
    )
    assert "1 000#0105" in frames
    assert outcomes == [
        "ERROR 1 Refusing is refused with 0x08000021 (local control)",
        "FAIL 1.1 none came",
    ]


def test_what_the_cleanup_does_is_not_judged_by_the_steps(played):
    _, outcomes = played(
        """\
- {at: 1, expect: {never: {nmt: stop}}}
- {at: 1, expect: {state: stopped, before: {nmt: stop}}}
duration: 2
cleanup:
  - {nmt: stop}
"""
    )
    assert outcomes == ["PASS 2 none came", "FAIL 2 none came"]


@pytest.mark.parametrize(
    ("duration", "last"), [(0, "0 705#00"), (0.35, "0.3 705#7F"), (0.4, "0.4 705#7F")]
)
def test_a_run_lasts_at_least_so_long(played, duration, last):
    frames, _ = played(f"- {{at: 0, write: {{Producer heartbeat: 100}}}}\nduration: {duration}\n")
    assert [frame for frame in frames if "705#" in frame][-1] == last


def test_progress_is_told_at_least_once_a_second(story):
    told = []
    play(story("- {at: 3.5, expect: {emcy: none, within: 1}}\n"), progress=told.append)
    assert told[:4] == [1.0, 2.0, 3.0, 4.0]
    assert told[-1] == pytest.approx(4.500001)


def test_nothing_is_waited_for_after_an_error(story):
    told = []
    play(story("- {at: 1, write: {Refusing: 1}}\n- {at: 9, nmt: stop}\n"), progress=told.append)
    assert told[-1] == pytest.approx(1)


def test_what_is_left_in_the_middle_of_a_run_counts_as_an_error(story):
    segment = Segment()
    node = connect(segment, Probe(node_id=5), "probe")
    player = Player(
        story(
            "- {at: 0, write: {Byte: 1}, every: 1, times: 9}\n"
            f"- {{after: 1, nmt: stop}}\n{CLEANUP}"
        ),
        segment,
        {"probe": node},
    )
    player.start()
    node.power_on()
    segment.advance(1.5)
    assert not player.done
    assert [(each.kind, each.line, each.seen) for each in player.verdict.outcomes] == [
        (Kind.ERROR, 4, "the run ended before it was decided"),
        (Kind.ERROR, 5, "1 step from here on was not reached"),
        (Kind.ERROR, 7, "2 steps from here on were not reached"),
    ]
    segment.advance(10)
    assert player.done
    assert player.verdict.outcomes == ()
