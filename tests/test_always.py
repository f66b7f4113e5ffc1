"""What a file expects every time that something is seen."""

import pytest

from canopen_twins import play
from canopen_twins.errors import UserError
from canopen_twins.scenario import load

HEAD = """\
version: 1
node: {device: topcon, node_id: 5, settings: {load: resistor 4}}
duration: 5
"""
STOPS = """\
always:
  - {whenever: {emcy: any}, expect: {write: {Run command: 0}, within: 0.5}}
"""


@pytest.fixture
def judged(tmp_path):
    """The outcomes of a file: line, seen, kind."""

    def judged(text):
        path = tmp_path / "story.yaml"
        path.write_text(HEAD + text)
        return [(o.line, o.seen, str(o.kind)) for o in play(load(path)).outcomes]

    return judged


def error(at):
    return f"  - {{at: {at}, inject: {{error: {{number: 0x23}}}}}}\n"


def command(at, value):
    return f"  - {{at: {at}, write: {{Run command: {value}}}}}\n"


ONCE = "".join(["steps:\n", error(1), command(1.1, 0), command(1.2, 2), command(1.3, 0)])
"""A good reaction to an error; its end is an EMCY, too."""


def test_it_is_expected_every_time(judged):
    assert judged(f"{STOPS}{ONCE}{error(3)}{command(3.4, 0)}") == [(5, "3 times", "PASS")]


def test_an_error_is_an_emcy_but_for_those_that_tell_of_its_end(judged):
    assert judged(f"{STOPS.replace('emcy: any', 'emcy: error')}{ONCE}") == [(5, "once", "PASS")]


def test_the_first_time_that_fails_is_told_when_it_fails(judged):
    assert judged(f"{STOPS}{ONCE}{error(3)}{command(3.4, 2)}") == [
        (5, "only Run command = 2", "FAIL")
    ]


def test_what_is_never_seen_is_nothing_to_judge(judged):
    assert judged(f"{STOPS}steps: []\n") == []


def test_what_is_still_open_in_the_end_is_not_judged(judged):
    assert judged(STOPS + "steps:\n" + error(4.9)) == []


def test_while_it_is_expected_it_does_not_begin_anew(judged):
    steps = "".join([error(1), command(1.2, 0), command(1.3, 2), command(1.6, 0)])
    text = STOPS.replace("within: 0.5", "within: 1")
    assert judged(f"{text}steps:\n{steps}") == [(5, "2 times", "PASS")]


def test_a_value_has_to_be_away_before_it_is_seen_again(judged):
    always = """\
always:
  - whenever: {value: {State of output: {min: 0x8000}}}
    expect: {write: {Run command: 2}, within: 1}
"""
    steps = "".join([error(1), command(1.5, 2), error(3), command(3.5, 2)])
    assert judged(f"{always}steps:\n{steps}") == [(5, "2 times", "PASS")]


def test_steps_and_rules_do_not_mind_each_other(judged):
    two = """\
always:
  - whenever: {write: {Run command: 1}}
    expect: {never: {emcy: any}, within: 0.5}
  - whenever: {frame: "705#00"}
    expect: {never: {write: {Run command: 1}}, before: {state: operational}}
steps:
  - {at: 0.2, nmt: start}
  - {at: 0.5, write: {Run command: 1}}
  - {at: 1, nmt: reset-node}
  - {at: 1.5, nmt: start}
  - {at: 2, write: {Run command: 1}}
  - {at: 2.1, inject: {error: {number: 0x23}}}
"""
    assert judged(two) == [(5, "2300/03/23", "FAIL"), (7, "2 times", "PASS")]


def test_it_may_begin_later(judged):
    always = """\
always:
  - whenever: {write: {Run command: 1}}
    after: 0.5
    expect: {never: {write: {Run command: 0}}, within: 1}
"""
    steps = "".join([command(1, 1), command(1.2, 0), command(3, 1), command(4, 0)])
    assert judged(f"{always}steps:\n{steps}") == [(5, "Run command = 0", "FAIL")]
    assert judged(f"{always}steps:\n{command(1, 1)}{command(1.2, 0)}") == [(5, "once", "PASS")]


LATER = """\
always:
  - whenever: {emcy: {code: 0x2300}}
    after: 0.2
    expect: {never: {write: {Run command: 1}}, before: {write: {Run command: 2}}}
"""


def test_what_ends_it_may_come_before_it_begins(judged):
    told = f"{LATER}steps:\n{error(1)}{command(1.1, 2)}{command(1.5, 1)}"
    assert judged(told) == []
    assert judged(told + error(3) + command(3.1, 0) + command(3.3, 1)) == [
        (5, "Run command = 1", "FAIL")
    ]


def test_a_value_that_ends_it_may_come_and_go_before_it_begins(judged):
    def refer(at, parts):
        return f"  - {{at: {at}, write: {{Voltage reference: {parts}}}}}\n"

    rule = LATER.replace("write: {Run command: 2}", "value: {Voltage reference: 7}")
    told = f"{rule}steps:\n{error(1)}{refer(1.05, 7)}{refer(1.1, 8)}{command(1.5, 1)}"
    assert judged(told) == []


def test_what_ends_it_is_waited_for_when_it_has_begun(judged):
    told = f"{LATER}steps:\n{error(1)}{command(1.3, 2)}{command(1.5, 1)}"
    assert judged(told) == [(5, "once", "PASS")]


LOST = """\
always:
  - {whenever: {heartbeat: any, missing: 0.5}, expect: {write: {Run command: 0}, within: 0.2}}
"""
BEATS = "  - {at: 0.1, write: {0x1017: 200}}\n"


def stopped(at, seconds):
    return f"  - {{at: {at}, inject: heartbeat_stopped, for: {seconds}}}\n"


def test_what_does_not_come_any_more_is_a_moment_each_time(judged):
    steps = f"{LOST}steps:\n{BEATS}{stopped(1, 1)}{command(1.5, 0)}{stopped(3, 1)}"
    assert judged(steps + command(3.5, 0)) == [(5, "2 times", "PASS")]
    assert judged(steps) == [(5, "none came", "FAIL")]


def test_what_does_not_come_any_more_ends_an_expectation_and_is_told_so(judged):
    expected = "  - {at: 0.5, expect: {emcy: any, before: {heartbeat: any, missing: 0.5}}}\n"
    ((_, *told),) = judged(f"steps:\n{BEATS}{expected}{stopped(1, 1)}")
    assert told == ["none came, before heartbeat missing for 0.5 s: none came", "FAIL"]


def test_what_is_late_but_not_too_late_is_none_and_so_is_what_never_came(judged):
    assert judged(f"{LOST}steps:\n{BEATS}{stopped(1, 0.3)}") == []
    assert judged(f"{LOST}steps: []\n") == []


@pytest.mark.parametrize(
    ("always", "said"),
    [
        ("{expect: {write: {Run command: 0}, within: 1}}", "whenever"),
        ("{whenever: {emcy: any}}", "expect"),
        ("{whenever: {emcy: any, nth: 2}, expect: {emcy: none, within: 1}}", "nth"),
        ("{whenever: {emcy: any}, expect: {write: {Run command: 0}}}", "within"),
        ("{whenever: {emcy: any, missing: 1}, expect: {emcy: none, within: 1}}", "missing"),
    ],
)
def test_a_rule_that_is_none_is_told(judged, always, said):
    with pytest.raises(UserError, match=said):
        judged(f"always:\n  - {always}\nsteps: []\n")
