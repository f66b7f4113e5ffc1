import pytest

from .conftest import HEAD


@pytest.fixture
def problem(problems):
    """What is wrong with one step that begins in line 4, column 5."""

    def problem(step):
        (found,) = problems(f"{HEAD}  - {step}\n")
        return found

    return problem


@pytest.mark.parametrize(
    ("step", "wrong"),
    [
        ("{nmt: start}", "4:5: nothing says when: a step has one of at, after, when"),
        ("{at: 1}", "4:5: nothing to do: a step has one of set, write, read, send, nmt, power,"),
        ("{at: 1, nmt: stop, power: on}", "4:5: nmt and power at once: a step has one of"),
        ("{at: 1, nmt: stop, nmt: stop}", "4:24: 'nmt' stands here twice, first in line 4"),
        ("{at: 1, nmt: stop, abort: 1}", "4:31: 'abort' stands beside 'write' or 'read' only"),
        ("{at: 1, nmt: stop, [a]: 1}", "4:24: one value is wanted here, not several"),
        ("{at: 1, do: stop}", "4:13: unknown key 'do'"),
        ("{at: soon, nmt: stop}", "4:10: 'soon' is no number; numbers look like 16, 0x10 or 0.5"),
        ("{at: true, nmt: stop}", "4:10: 'true' is no number"),
        ("at:\n    nmt: stop", "4:8: '' is no number"),
        ("{at: 1e999, nmt: stop}", "4:10: '1e999' is no number"),
        ("{at: 086, nmt: stop}", "4:10: 086 may be taken for different numbers"),
        ("{at: 1_0, nmt: stop}", "4:10: 1_0 may be taken for different numbers"),
        ("{at: 1:30, nmt: stop}", "4:10: '1:30' is no number"),
        ("{at: 90000, nmt: stop}", "4:10: 90000 s is not in 0..86400 s"),
        ("{at: 1, note: {}, nmt: stop}", "4:19: one value is wanted here, not several"),
    ],
)
def test_a_step_has_a_time_and_one_verb(problem, step, wrong):
    assert problem(step).startswith(wrong)


@pytest.mark.parametrize(
    ("step", "wrong"),
    [
        ("{at: 1, nmt: reset}", "4:18: unknown NMT command 'reset': did you mean"),
        ("{at: 1, power: true}", "4:20: unknown position of the supply 'true': there is off, on"),
        ("{at: 1, send: 080}", "4:19: '080' is no frame: write ID#DATA or ID#R"),
        ("{at: 1, send: 800#}", "4:19: '800#': identifiers end at 7FF"),
        ("{at: 1, send: 080#0}", "4:19: '080#0': data are at most 8 bytes of two hex digits"),
        ("{at: 1, inject: eror}", "4:21: unknown fault 'eror': did you mean 'error'?"),
        ("{at: 1, inject: {eror: {}}}", "4:22: unknown fault 'eror': did you mean 'error'?"),
        ("{at: 1, inject: {error: {cod: 1}}}", "4:30: unknown parameter of fault 'error' 'cod'"),
        ("{at: 1, inject: {error: {code: x}}}", "4:36: parameter 'code' of fault 'error' wants"),
        ("{at: 1, inject: {error: {}}}", "4:29: fault 'error' wants 'code'"),
        ("{at: 1, inject: error}", "4:21: fault 'error' wants 'code'"),
        ("{at: 1, inject: {error: 5}}", "4:29: a key with a value is wanted here"),
        ("{at: 1, clear: eror}", "4:20: unknown fault 'eror': did you mean 'error'?"),
        ("{at: 1, set: {node_id: 6}}", "4:28: setting 'node_id' is taken over at power-on only"),
        ("{at: 1, set: {self: 6}}", "4:19: unknown setting 'self'"),
        ("{at: 1, set: {}}", "4:18: empty; at least one key"),
        ("{at: 1, inject: {}}", "4:21: empty; at least one key"),
        ("{at: 1, set: open}", "4:18: a key with a value is wanted here"),
    ],
)
def test_what_a_verb_does_not_understand_is_pointed_at(problem, step, wrong):
    assert problem(step).startswith(wrong)


@pytest.mark.parametrize(
    ("written", "wrong"),
    [
        ("{Byt: 1}", "4:21: unknown object 'Byt': did you mean 'Byte'?"),
        ("{0x2F00: 1}", "4:21: unknown object '0x2F00': did you mean '0x2"),
        ("{0x200D: 1}", "4:21: 0x200D is a record: say which entry of it, such as 0x200D:01"),
        ("{0x200D:2: 1}", "4:21: '0x200D:2' is no address; addresses look like 0x2014 or"),
        ("{0x200D:02: 1}", "4:21: unknown object '0x200D:02': did you mean '0x200D:"),
        ("{8192: 1}", "4:21: unknown object '8192'"),
        ("{Byte: -1}", "4:27: -1 is not in 0..255"),
        ("{Byte: one}", "4:27: 'one' is no number"),
        ("{Byte: '1'}", "4:27: '1' stands in quotes and is a text: write 1"),
        ("{Byte: 1.5}", "4:27: 1.5 is no whole number"),
        ("{Byte: 010}", "4:27: 010 may be taken for different numbers"),
        ("{Limited: 101}", "4:30: 101 is not in -100..100; if that is the point, put the abort"),
        ("{Three bytes: 0x800000}", "4:34: 0x800000 is not in -8388608..8388607"),
        ("{Eight bytes: -1}", "4:34: -1 is not in 0..18446744073709551615"),
        ("{Real: much}", "4:27: 'much' is no number"),
        ("{Real: 1e300}", "4:27: '1e300' does not fit this object"),
        ("{Text: é}", "4:27: 'é' does not fit this object"),
        ("{Truth: 1}", "4:28: unknown truth value '1': there is false, true"),
        ("{Domain: 1}", "4:21: objects of data type 0x000f cannot be written here"),
        ("{Read only: 1}", "4:21: 'Read only' is read only; if that is the point, put abort:"),
        ("{Byte: {a: 1}}", "4:27: one value is wanted here, not several"),
        ("{}", "4:20: empty; at least one key with a value is wanted here"),
        ("Byte", "4:20: a key with a value is wanted here"),
    ],
)
def test_only_what_an_object_takes_is_written(problem, written, wrong):
    assert problem(f"{{at: 1, write: {written}}}").startswith(wrong)


@pytest.mark.parametrize(
    ("step", "wrong"),
    [
        ("{at: 1, write: {Byte: 1}, abort: 0}", "4:38: 0 is no abort code; they look like"),
        ("{at: 1, write: {Byte: 1}, abort: -1}", "4:38: -1 is not in 0..0xffffffff"),
        ("{at: 1, write: {Byte: 256}, abort: 1}", "4:27: 256 is not in 0..255"),
        ("{at: 1, write: {Byt: 256}, abort: 1}", "4:21: unknown object 'Byt'"),
        ("{at: 1, write: {Byte: 1, Word: 1}, abort: 1}", "4:20: one object at a time can be"),
    ],
)
def test_a_write_that_shall_be_refused_has_its_rules_too(problem, step, wrong):
    assert problem(step).startswith(wrong)


@pytest.mark.parametrize(
    ("expected", "wrong"),
    [
        ("{within: 1}", "4:21: nothing to expect: a step has one of emcy, value, frame, heartbeat"),
        ("{emcy: none, silence: true, within: 1}", "4:21: emcy and silence at once"),
        ("{emyc: none, within: 1}", "4:22: unknown key 'emyc': did you mean 'emcy'?"),
        ("{emcy: none}", "4:21: 'within' is missing: the seconds it may take"),
        ("{emcy: none, within: -1}", "4:42: -1 s is not in 0..86400 s"),
        ("{emcy: some, within: 1}", "4:28: unknown EMCY 'some': there is any, error, none"),
        ("{emcy: {}, within: 1}", "4:28: empty; at least one key with a value is wanted here"),
        ("{emcy: {cod: 1}, within: 1}", "4:29: unknown key 'cod': did you mean 'code'?"),
        ("{emcy: {code: 0x10000}, within: 1}", "4:35: 0x10000 is not in 0..0xffff"),
        ("{emcy: {register: 256}, within: 1}", "4:39: 256 is not in 0..0xff"),
        ("{frame: '185#xyz*', within: 1}", "4:29: '185#xyz*' is no frame"),
        ("{frame: 185, within: 1}", "4:29: '185' is no frame"),
        ("{frame: '185#3', within: 1}", "4:29: '185#3': data are"),
        ("{heartbeat: operating, within: 1}", "4:33: unknown heartbeat 'operating': did you mean"),
        ("{silence: false, within: 1}", "4:31: unknown silence 'false': there is true"),
        ("{value: {}}", "4:29: empty; at least one key"),
        ("{value: {Byt: 1}}", "4:30: unknown object 'Byt': did you mean 'Byte'?"),
        ("{value: {Byte: one}}", "4:36: 'one' is no number"),
        ("{value: {Byte: {}}}", "4:36: wanted is {is: 5}, {is: 5, tolerance: 1}, {min: 4}"),
        ("{value: {Byte: {mni: 1}}}", "4:37: unknown key 'mni': did you mean 'min'?"),
        ("{value: {Byte: {tolerance: 5}}}", "4:36: wanted is {is: 5}"),
        ("{value: {Byte: {is: 1, max: 5}}}", "4:36: wanted is {is: 5}"),
        ("{value: {Byte: {min: 1, tolerance: 5}}}", "4:36: wanted is {is: 5}"),
        ("{value: {Byte: {min: 2, max: 1}}}", "4:36: no value is in 2..1"),
        ("{value: {Byte: {is: 2, tolerance: -1}}}", "4:36: no value is in 3..1"),
        ("{value: {Text: {is: 1}}}", "4:36: one value is wanted here, not several"),
    ],
)
def test_what_cannot_be_expected_is_pointed_at(problem, expected, wrong):
    assert problem(f"{{at: 1, expect: {expected}}}").startswith(wrong)


def test_steps_stand_in_the_order_of_their_times(problems):
    steps = "  - {at: 1.5, nmt: start}\n  - {at: 1, nmt: stop}\n  - {at: 1.2, nmt: stop}\n"
    assert problems(HEAD + steps) == [
        "5:10: 1 s is before 1.5 s, of a step above",
        "6:10: 1.2 s is before 1.5 s, of a step above",
    ]


def test_what_is_expected_of_a_moment_stands_behind_what_is_done_in_it(problems):
    steps = "  - {at: 1, expect: {value: {Byte: 1}}}\n  - {at: 1, write: {Byte: 1}}\n"
    (problem,) = problems(HEAD + steps)
    assert problem.startswith("5:5: put it before what is expected at the same time")


def test_settings_and_faults_are_tried_on_the_device_itself(problems):
    text = """\
        version: 1
        node: {device: topcon}
        steps:
          - {at: 1, set: {load: opne}}
          - {at: 1, set: {load: open, ambient: cold}}
          - {at: 1, inject: {mains: {volts: 1000}}}
          - {at: 1, inject: {interlock_open: {}, error: {number: 0x14D}}}
          - {at: 1, inject: {sdo_abort: {object: Voltage}}}
          - {at: 1, inject: {sdo_abort: {nth: 0}}}
        """
    found = problems(text)
    places = [line.split(": ")[0] for line in found]
    assert places == ["4:25", "5:40", "6:29", "7:49", "8:33", "9:39"]
