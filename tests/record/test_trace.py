import subprocess
import sys
from io import StringIO
from itertools import pairwise

import can
import pytest
from probe import Probe

from canopen_twins.bus.clock import microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.record.trace import trace_file
from canopen_twins.scenario import print_frames

SUFFIXES = [".log", ".asc", ".blf", ".trc"]
STORY = ["705#R", "605#4018100100000000", "18FEF105#0102030405060708", "000#0105", "7FF#"]


def interrupt(segment, player):
    def hear(frame, sender):
        if str(frame) == STORY[-1]:
            raise KeyboardInterrupt

    segment.listeners.append(hear)


@pytest.fixture
def lived():
    """What was on a bus on which a probe is asked this and that."""

    def live(*observers):
        segment = Segment()
        node = connect(segment, Probe(node_id=5), "probe")
        for attach in observers:
            attach(segment, None)
        segment.advance(0.123457)
        node.power_on()
        segment.deliver()
        for text in STORY:
            segment.advance(0.1)
            segment.send(Frame.parse(text))

    return live


def read(path):
    with can.LogReader(path) as reader:
        return list(reader)


def frame(message):
    remote, extended = message.is_remote_frame, message.is_extended_id
    return Frame(message.arbitration_id, bytes(message.data), remote, extended)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_trace_file_holds_every_frame_with_its_time(lived, tmp_path, suffix):
    text = StringIO()
    with trace_file(tmp_path / f"out{suffix}") as observer:
        lived(observer, print_frames(text))
    told = [
        f"({message.timestamp:017.6f}) can0 {frame(message)}"
        for message in read(tmp_path / f"out{suffix}")
    ]
    assert told == text.getvalue().splitlines()
    assert told[0] == "(0000000000.123457) can0 705#00"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_twins_send_goes_out_and_everything_else_comes_in(lived, tmp_path, suffix):
    with trace_file(tmp_path / f"out{suffix}") as observer:
        lived(observer)
    out = [str(frame(message)) for message in read(tmp_path / f"out{suffix}") if not message.is_rx]
    heard = [str(frame(message)) for message in read(tmp_path / f"out{suffix}") if message.is_rx]
    assert out[0] == "705#00"
    assert heard == STORY


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_run_gives_the_same_file(lived, tmp_path, suffix):
    contents = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        with trace_file(tmp_path / folder / f"out{suffix}") as observer:
            lived(observer)
        contents.append((tmp_path / folder / f"out{suffix}").read_bytes())
    assert contents[0] == contents[1]


def test_times_are_whole_microseconds_in_every_format(said, tmp_path):
    ticks = []
    for suffix in SUFFIXES:
        path = tmp_path / f"out{suffix}"
        assert said("play", "gateway_link_cut.yaml", "--trace", path)[0] == 0
        ticks.append([microseconds(message.timestamp) for message in read(path)])
    assert 220_625 in ticks[0]
    assert all(one == other for one, other in pairwise(ticks))


def test_what_is_printed_is_the_same_with_a_trace_file(said, tmp_path):
    plain = said("play", "topcon_overvoltage.yaml")
    assert said("play", "topcon_overvoltage.yaml", "--trace", tmp_path / "out.asc") == plain


def test_until_the_end_the_file_has_another_name(lived, tmp_path):
    path = tmp_path / "out.log"
    path.write_text("of yesterday")
    with pytest.raises(KeyboardInterrupt), trace_file(path) as observer:
        lived(observer, interrupt)
    assert path.read_text() == "of yesterday"
    assert "705#00 T\n" in (tmp_path / "out.log.part").read_text()
    with trace_file(path) as observer:
        lived(observer)
    assert "705#00 T\n" in path.read_text()
    assert [each.name for each in tmp_path.iterdir()] == ["out.log"]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("out.pcap", "out.pcap is no trace file: its name ends in .log, .asc, .blf, .trc"),
        ("nowhere/out.log", "nowhere/out.log: there is no directory for it"),
        ("folder.log", "folder.log is a directory, where a plain file is wanted"),
    ],
)
def test_where_no_trace_file_can_be_is_told_before_anything_runs(tmp_path, name, told):
    (tmp_path / "folder.log").mkdir()
    with pytest.raises(UserError) as refusal, trace_file(tmp_path / name):
        pytest.fail("it runs")
    assert str(refusal.value) == f"{tmp_path}/{told}"


def test_a_suffix_may_be_in_capitals(lived, tmp_path):
    with trace_file(tmp_path / "OUT.ASC") as observer:
        lived(observer)
    assert len(read(tmp_path / "OUT.ASC")) > len(STORY)


def test_a_full_disk_is_told_in_a_line(tmp_path):
    command = f"{sys.executable} -m canopen_twins play topcon_overvoltage.yaml --trace out.log"
    done = subprocess.run(
        f"ulimit -f 0; exec {command} | cat",
        shell=True,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == "canopen-twin: the output cannot be written: File too large\n"
