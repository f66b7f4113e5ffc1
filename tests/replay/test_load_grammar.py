import pytest

from canopen_twins.scenario.actions import Expectation, Inject, Read, Send, Write
from canopen_twins.scenario.frame_matchers import (
    AnyFrame,
    Commanded,
    EmcyLike,
    FrameLike,
    HeartbeatLike,
)
from canopen_twins.scenario.matchers import Condition, Entered, Holds, Written
from canopen_twins.scenario.scenario import After, At
from canopen_twins.scenario.values import Anything, Range, Text
from canopen_twins.slave.service import State

TWO = """\
version: 1
nodes:
  left: {device: probe, node_id: 5}
  right: {device: probe, node_id: 6}
steps:
"""


@pytest.fixture
def read(loaded):
    """One step of two probes, left and right, as it was read."""

    def read(step):
        (step,) = loaded(f"{TWO}  - {{{step}}}\n").steps
        return step

    return read


@pytest.fixture
def problem(problems):
    """What is wrong with one step of two probes; it begins in line 6, column 5."""

    def problem(step):
        (found,) = problems(f"{TWO}  - {{{step}}}\n")
        return found

    return problem


@pytest.fixture
def met(read):
    """A condition, without the names of objects that only tell."""
    return lambda told: read(f"when: {{{told}}}, node: left, nmt: start").moment


@pytest.fixture
def expected(read):
    return lambda told: read(f"at: 1, node: left, expect: {{{told}}}").action


def test_a_step_has_one_of_three_moments(loaded):
    scenario = loaded(
        TWO
        + """\
          - {at: 1.5, node: left, nmt: start}
          - {after: 0.5, node: right, nmt: start}
          - {when: {emcy: any}, node: right, nmt: start}
          - {at: 1.5, node: left, nmt: start}
        """
    )
    assert [step.moment for step in scenario.steps] == [
        At(1.5),
        After(0.5),
        Condition(EmcyLike(), "right"),
        At(1.5),
    ]
    assert [step.node for step in scenario.steps] == ["left", "right", "right", "left"]


def test_a_step_is_repeated(read):
    step = read("at: 0, every: 0.1, times: 20, node: left, nmt: start")
    assert (step.every, step.times) == (0.1, 20)


def test_a_frame_is_sent_to_nobody_in_particular(read):
    step = read("at: 0, send: 080#")
    assert (step.node, type(step.action)) == ("", Send)


@pytest.mark.parametrize(
    ("told", "matcher"),
    [
        ("emcy: any", EmcyLike()),
        ("emcy: {code: 0x2300, detail: 0x23}", EmcyLike(0x2300, None, 0x23)),
        ("frame: 185#d0.07*", FrameLike("185#D007*")),
        ("frame: 205#xx, from: master", FrameLike("205#XX", by_master=True)),
        ("heartbeat: any", HeartbeatLike()),
        ("heartbeat: stopped", HeartbeatLike(State.STOPPED)),
        ("state: initialising", Entered(State.INITIALISING)),
        ("state: operational", Entered(State.OPERATIONAL)),
        ("nmt: reset-node", Commanded(0x81)),
    ],
)
def test_a_condition_is_a_matcher(met, expected, told, matcher):
    assert met(told) == Condition(matcher, "left")
    assert expected(f"{told}, within: 2") == Expectation(matcher, 2.0)
    assert expected(f"never: {{{told}}}, within: 2") == Expectation(matcher, 2.0, never=True)


@pytest.mark.parametrize(
    ("key", "kind", "told", "wanted"),
    [
        ("value", Holds, "Byte: {min: 4}", Range(4)),
        ("value", Holds, "Text: abc", Text("abc")),
        ("write", Written, "Byte: any", Anything()),
        ("write", Written, "0x2F00: 0x10", Range(16, 16, True)),
    ],
)
def test_a_condition_is_about_objects(met, key, kind, told, wanted):
    matcher = met(f"{key}: {{{told}}}").matcher
    assert type(matcher) is kind
    assert [each for _, each in matcher.wanted] == [wanted]


def test_a_condition_counts_and_may_be_about_another_node(met):
    assert met("emcy: any, nth: 3, node: right") == Condition(EmcyLike(), "right", 3)


@pytest.mark.parametrize(
    ("told", "expectation"),
    [
        ("emcy: none, within: 1", Expectation(EmcyLike(), 1.0, never=True)),
        ("heartbeat: none, within: 1", Expectation(HeartbeatLike(), 1.0, never=True)),
        ("silence: true, within: 1", Expectation(AnyFrame(), 1.0, never=True)),
        (
            "silence: true, from: master, within: 1",
            Expectation(AnyFrame(by_master=True), 1.0, never=True),
        ),
        (
            "nmt: start, before: {state: stopped, node: right}",
            Expectation(Commanded(1), None, Condition(Entered(State.STOPPED), "right")),
        ),
        (
            "never: {nmt: start}, within: 2, before: {emcy: any}",
            Expectation(Commanded(1), 2.0, Condition(EmcyLike(), "left"), never=True),
        ),
    ],
)
def test_an_expectation_has_a_window(expected, told, expectation):
    assert expected(told) == expectation


def test_a_value_is_expected_at_once(expected):
    assert expected("value: {Byte: 1}").seconds == 0


@pytest.mark.parametrize(
    ("beside", "lasts"),
    [("", None), (", for: 2", 2.0), (", until: {nmt: start}", Condition(Commanded(1), "left"))],
)
def test_a_fault_heals_by_itself(read, beside, lasts):
    step = read(f"at: 1, node: left, inject: {{sdo_silence: {{times: 2}}}}{beside}")
    assert step.action == Inject({"sdo_silence": {"times": 2}}, lasts)


@pytest.mark.parametrize(
    ("beside", "abort", "timeout"),
    [
        ("", 0, 1.0),
        (", timeout: 0.2", 0, 0.2),
        (", abort: none", None, 1.0),
        (", abort: 5", 5, 1.0),
    ],
)
def test_transfers_are_refused_or_not_answered(read, beside, abort, timeout):
    for verb, kind in (("write", Write), ("read", Read)):
        action = read(f"at: 1, node: left, {verb}: {{Byte: 1}}{beside}").action
        assert isinstance(action, kind)
        assert (action.abort, action.timeout) == (abort, timeout)


def test_objects_of_any_length_are_read_and_written(read):
    write = read("at: 1, node: left, write: {Text: longer than four, Eight bytes: 1}").action
    assert [each.data for each in write.downloads] == [b"longer than four", b"\1" + bytes(7)]
    told = "{Text: any, Byte: {min: 1}, Eight bytes: 5}"
    uploads = read(f"at: 1, node: left, read: {told}").action.uploads
    assert [wanted for _, wanted in uploads] == [Anything(), Range(1), Range(5, 5)]


@pytest.mark.parametrize(
    ("step", "wrong"),
    [
        ("at: 1, after: 2, send: 080#", "6:5: at and after at once: a step has one of at, after"),
        ("at: 1, nmt: start", "6:5: 'node' is missing: which of left, right"),
        ("at: 1, node: rigth, nmt: start", "6:19: unknown node 'rigth': did you mean 'right'?"),
        ("at: 1, node: rigth, send: 080#", "6:19: unknown node 'rigth': did you mean 'right'?"),
        ("at: 1, every: 1, node: left, nmt: start", "6:20: 'every' stands beside 'times' only"),
        ("at: 1, times: 2, node: left, nmt: start", "6:20: 'times' stands beside 'every' only"),
        ("at: 1, every: 0, times: 2, send: 080#", "6:20: 0 s is no time; it has to be more"),
        ("at: 1, every: 1, times: 0, send: 080#", "6:30: 0 is not in 1..100000"),
        ("at: 1, every: 1, times: 100001, send: 080#", "6:30: 100001 is not in 1..100000"),
        ("at: 1, for: 1, send: 080#", "6:18: 'for' stands beside 'inject' only"),
        ("at: 1, until: {emcy: any, node: left}, send: 080#", "6:20: 'until' stands beside"),
        ("at: 1, timeout: 1, send: 080#", "6:22: 'timeout' stands beside 'write' or 'read' only"),
        (
            "at: 1, node: left, inject: sdo_silence, for: 1, until: {emcy: any}",
            "6:54: for and until at once: leave one out",
        ),
        (
            "at: 1, node: left, inject: {level: {value: 1}}, for: 1",
            "6:34: fault 'level' is over at once: leave 'for' and 'until' out",
        ),
        (
            "when: {node: left}, send: 080#",
            "6:12: nothing to wait for: a condition has",
        ),
        ("when: {emcy: any}, send: 080#", "6:12: 'node' is missing: which of left, right"),
        (
            "when: {emyc: any, node: left}, send: 080#",
            "6:13: unknown key 'emyc': did you mean 'emcy'?",
        ),
        ("when: {emcy: none, node: left}, send: 080#", "6:19: unknown EMCY 'none': there is any"),
        ("when: {emcy: any, nth: 0, node: left}, send: 080#", "6:29: 0 is not in 1..100000"),
        ("when: {silence: true, node: left}, send: 080#", "6:13: unknown key 'silence'"),
        ("when: {emcy: any, node: up}, send: 080#", "6:30: unknown node 'up'"),
        ("when: {state: running, node: left}, send: 080#", "6:20: unknown NMT state 'running'"),
        ("when: {value: {Byt: 1}, node: left}, send: 080#", "6:21: unknown object 'Byt': did"),
        ("when: 5, send: 080#", "6:12: a key with a value is wanted here, such as {key: value}"),
        ("at: 1, node: left, read: {Write only: any}", "6:32: 'Write only' is write only; if"),
        ("at: 1, node: left, read: {Byt: any}", "6:32: unknown object 'Byt': did you mean"),
        ("at: 1, node: left, read: {}", "6:31: empty; at least one key with a value"),
        ("at: 1, node: left, read: {Byte: 1, Word: 1}, abort: 1", "6:31: one object at a time"),
        ("at: 1, node: left, write: {Byte: 1}, abort: nine", "6:50: 'nine' is no number"),
    ],
)
def test_what_does_not_go_together_is_pointed_at(problem, step, wrong):
    assert problem(step).startswith(wrong)


@pytest.mark.parametrize(
    ("expected", "wrong"),
    [
        ("never: {silence: true}", "6:42: unknown key 'silence'"),
        ("never: {emcy: none}", "6:48: unknown EMCY 'none': there is any"),
        ("never: {emcy: any}, emcy: any", "6:33: emcy and never at once: a step has one of"),
        ("never: {frame: 185#}, from: master", "6:62: 'from' stands beside 'frame' or 'silence'"),
        ("never: {nmt: start, from: master}", "6:60: 'from' stands beside 'frame' only"),
        ("never: {}", "6:41: nothing to look for: never has one of emcy, value"),
        ("frame: 185#, from: slave, within: 1", "6:53: unknown sender 'slave': there is master"),
        ("frame: 185#", "6:33: 'within' is missing: the seconds it may take, or 'before'"),
        ("nmt: start, before: {nmt: sotp}", "6:60: unknown NMT command 'sotp': did you mean"),
    ],
)
def test_what_cannot_be_expected_is_pointed_at(problem, expected, wrong):
    assert problem(f"at: 1, node: left, expect: {{{expected}}}").startswith(wrong)
