import gzip

import pytest

from canopen_twins.record.differences import AHEAD, compare

from .conftest import STORY, edit

SUFFIXES = [".log", ".asc", ".blf", ".trc"]


@pytest.fixture
def traces(said, story, tmp_path):
    """The same run in every format."""
    paths = [tmp_path / f"out{suffix}" for suffix in SUFFIXES]
    for path in paths:
        assert said("play", story(), "--trace", path)[0] == 0
    return paths


def test_two_records_of_the_same_play_are_equal(said, recorded):
    code, out, err = said("diff", recorded(name="a"), recorded(name="b"))
    assert (code, err) == (0, "")
    assert out.startswith("the same ")
    assert out.count("\n") == 1


def test_a_trace_is_equal_in_every_format(said, traces):
    for path in traces:
        assert said("diff", traces[0], path) == (0, "the same 11 frames\n", "")


def test_a_record_can_be_compared_with_a_trace(said, recorded, traces):
    assert said("diff", recorded(), traces[1]) == (0, "the same 11 frames\n", "")


def test_a_packed_trace_is_read_too(said, traces, tmp_path):
    packed = tmp_path / "out.log.gz"
    packed.write_bytes(gzip.compress(traces[0].read_bytes()))
    assert said("diff", traces[0], packed)[0] == 0


def test_the_first_difference_is_told_with_what_was_before_and_beside(said, recorded):
    text = STORY.replace("number: 0x23", "number: 0x24").replace("resistor 4", "open")
    code, out, _ = said("diff", recorded(name="a"), recorded(text, name="b"))
    assert code == 1
    assert out.splitlines() == [
        "the first 3 frames are the same:",
        "            0.000000  705#00                 boot-up",
        "            0.100000  605#2B17100064000000   SDO write 0x1017:00 Producer Heartbeat Time"
        " = 100",
        "            0.100000  585#6017100000000000   SDO written 0x1017:00 Producer Heartbeat"
        " Time",
        "A           0.200000  085#0023032300000000   EMCY 2300h register 03h",
        "B           0.200000  085#0023032400000000   EMCY 2300h register 03h",
        "other data: byte 3 is 23 in A, 24 in B",
        "what is not the same from the beginning:",
        "        load of topcon: resistor 4 in A, open in B",
        "        line 3 of the scenario: 'node: {device: topcon, node_id: 5, settings: {load:"
        " resistor 4}}' / 'node: {device: topcon, node_id: 5, settings: {load: open}}'",
        "what happened in A:",
        "            0.200000  topcon      step of line 6: inject",
        "            0.200000  topcon      fault error(number=35) injected",
        "            0.200000  topcon      EMCY 2300h register 03h gate driver A fault",
        "            0.200000  topcon      step of line 7: EMCY 2300/xx/xx within 0.05 s",
        "            0.200000  topcon      PASS of line 7: EMCY 2300/xx/xx within 0.05 s:"
        " 2300/03/23",
        "what happened in B:",
        "            0.200000  topcon      step of line 6: inject",
        "            0.200000  topcon      fault error(number=36) injected",
        "            0.200000  topcon      EMCY 2300h register 03h gate driver B fault",
        "            0.200000  topcon      step of line 7: EMCY 2300/xx/xx within 0.05 s",
        "            0.200000  topcon      PASS of line 7: EMCY 2300/xx/xx within 0.05 s:"
        " 2300/03/24",
    ]


FRAMES = [(0.1, "705#05"), (0.2, "185#0102"), (0.3, "285#03"), (0.4, "385#04")]
CHANGES = [
    ([(0.1, "705#04"), *FRAMES[1:]], "not even the first frame is the same:"),
    ([(0.1, "705#04"), *FRAMES[1:]], "other data: byte 0 is 05 in A, 04 in B"),
    (FRAMES[1:], "A has 1 frame more, then the other goes on like it"),
    ([(0.05, "080#"), *FRAMES], "B has 1 frame more, then the other goes on like it"),
    (FRAMES[:2], "B ends here, A goes on"),
    ([*FRAMES, (0.5, "080#")], "A ends here, B goes on"),
    ([FRAMES[0], (0.25, "185#0102")], "the same frame, 0.050000 s later in B"),
    ([FRAMES[0], (0.15, "185#0102")], "the same frame, 0.050000 s later in A"),
    ([FRAMES[0], (0.2, "185#0103")], "other data: byte 1 is 02 in A, 03 in B"),
    (
        [FRAMES[0], (0.3, "185#F10F")],
        "other data, 0.100000 s later in B: byte 0 is 01 in A, F1 in B, byte 1 is 02 in A, 0F in B",
    ),
    ([FRAMES[0], (0.2, "185#01")], "another frame"),
    ([FRAMES[0], (0.21, "186#0102")], "another frame, 0.010000 s later in B"),
    ([], "B ends here, A goes on"),
]


def log(path, frames):
    path.write_text("".join(f"({time:017.6f}) can0 {frame}\n" for time, frame in frames))
    return path


@pytest.mark.parametrize(("frames", "told"), CHANGES)
def test_what_has_changed_is_said_in_words(said, tmp_path, frames, told):
    paths = log(tmp_path / "a.log", FRAMES), log(tmp_path / "b.log", frames)
    code, out, _ = said("diff", *paths)
    assert code == 1
    assert told in out.splitlines()


def test_a_remote_frame_is_no_data_frame(said, tmp_path):
    paths = log(tmp_path / "a.log", [(0, "185#")]), log(tmp_path / "b.log", [(0, "185#R")])
    code, out, _ = said("diff", *paths)
    assert code == 1
    assert "a frame of another kind" in out.splitlines()


def test_what_is_not_the_same_is_told_of_equal_records_too(said, recorded):
    a, b = recorded(name="a"), recorded(f"{STORY}# changed\n", name="b")
    code, out, _ = said("diff", a, b)
    assert code == 0
    assert out.splitlines()[1:] == [
        "what is not the same from the beginning:",
        "        line 11 of the scenario: none / '# changed'",
    ]


LONG = "9" * 200
OTHERS = [
    ('"seed": 1', '"seed": 2', "seed: 1 in A, 2 in B"),
    ('"kind": "play"', '"kind": "run"', "kind: play in A, run in B"),
    (
        '"memory": {}',
        '"memory": {"a": {"b": 1}}',
        "memory of topcon: {} in A, {'a': {'b': 1}} in B",
    ),
    ('"files": {}', '"files": {"x.yaml": "ab"}', "content of x.yaml: none in A, ab in B"),
    ('"name": "topcon"', '"name": "t"', "device of topcon: topcon in A, none in B"),
    ('"python": "', '"python": "9', "version of python: "),
    (
        '"load": "resistor 4"',
        f'"load": "{LONG}"',
        f"resistor 4 in A, {LONG[:120]}... in B",
    ),
]


@pytest.mark.parametrize(("old", "new", "told"), OTHERS)
def test_every_part_of_a_run_is_compared(said, recorded, old, new, told):
    a, b = recorded(name="a"), recorded(name="b")
    edit(b / "run.json", old, new)
    code, out, _ = said("diff", a, b)
    assert code == 0
    assert told in out


def test_a_record_of_a_device_that_is_here_no_more_has_its_frames(said, recorded):
    folders = recorded(name="a"), recorded(STORY.replace("number: 0x23", "number: 0x24"), name="b")
    for folder in folders:
        file = folder / "run.json"
        file.write_text(file.read_text().replace('"device": "topcon"', '"device": "other"'))
    code, out, _ = said("diff", *folders)
    assert code == 1
    assert "            0.100000  585#6017100000000000   SDO written 0x1017:00\n" in out


WRONG = [
    ("out.xyz", "x", "its name ends in .asc, .blf, .csv, .log, .mf4, .trc, .txt"),
    ("out.log", None, "out.log is not there"),
    ("out.log", "(x) can0 705#00", "out.log cannot be read as .log: "),
    ("out.blf", "LOGG", "out.blf cannot be read as .blf: "),
    ("out.trc", ";$FILEVERSION=2.1\n1 x", "out.trc cannot be read as .trc: "),
    ("out.mf4", "x", "out.mf4 cannot be read as .mf4: "),
    ("out.log.gz", "plain", "out.log.gz cannot be read as .log: "),
    ("out.log", "x" * 70_000, "cannot be read as .log: a line of 65536 characters or more"),
    ("trace", "x", "trace is no trace file"),
]


@pytest.mark.parametrize(("name", "text", "told"), WRONG)
def test_what_cannot_be_read_is_told_in_a_line(said, traces, tmp_path, name, text, told):
    path = tmp_path / "other" / name
    path.parent.mkdir()
    if text is not None:
        path.write_text(text)
    code, out, err = said("diff", traces[0], path)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert told in err


def test_a_directory_that_is_no_record_is_told_in_a_line(said, traces, tmp_path):
    code, _, err = said("diff", traces[0], tmp_path)
    assert (code, err) == (2, f"canopen-twin: {tmp_path}/run.json: No such file or directory\n")


def test_no_more_is_read_than_the_difference_needs():
    read = []

    def numbers(first):
        for number in range(first, 10**9):
            read.append(number)
            yield number

    found = compare(numbers(0), iter([0, 1, 2, 99, 100]))
    assert (found.common, found.before, found.right) == (3, (0, 1, 2), (99, 100))
    assert len(read) == 4 + AHEAD
