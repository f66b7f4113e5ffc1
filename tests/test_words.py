"""What a live run prints as it happens, and its state when somebody asks for it."""

import io
import json
import os
import re
import signal
import subprocess
import sys

import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.cli import main
from canopen_twins.cli.words import MOST_WAITING, Printer, Words, is_coloured
from canopen_twins.devices import create
from canopen_twins.faults import connect
from canopen_twins.scenario import begin

PATIENCE = 30.0
PROGRAM = [sys.executable, "-m", "canopen_twins"]
REFUSED = "605#2B14200007000000"  # there is no command 7


class Sink:
    """Takes lines."""

    def __init__(self):
        self.lines = []
        self.put = self.lines.append


@pytest.fixture
def told():
    """The lines about a TopCon that boots, hears frames and has a fault."""

    def told(*frames, coloured=False, quiet=False, fault=""):
        sink, segment = Sink(), Segment()
        node = connect(segment, create("topcon", node_id=5), "topcon")
        begin(segment, None, [Words(sink.put, coloured, quiet).attach])
        segment.deliver()
        for frame in frames:
            segment.send(Frame.parse(frame))
        if fault:
            with node.acting():
                node.faults.inject(fault)
            segment.advance(0.02)
        return sink.lines

    return told


def test_frames_refusals_and_states_are_told_in_words(told):
    assert told("605#4000100000000000", REFUSED, "000#0105") == [
        "    0.000000  topcon      pre-operational",
        "    0.000000  topcon      705#00                 boot-up",
        "    0.000000  -           605#4000100000000000   SDO read 0x1000:00 Device Type",
        "    0.000000  topcon      585#4300100000000000   SDO answer 0x1000:00 Device Type = 0",
        f"    0.000000  -           {REFUSED}   SDO write 0x2014:00 Run command = 7",
        "    0.000000  topcon      585#8014200030000906   SDO abort 0x2014:00 Run command,"
        " 06090030h Value range of parameter exceeded",
        f"              why: {REFUSED} refused: no command 7: 0 stops, 1 runs, 2 resets,"
        " Run command (manual 7.3.9)",
        "    0.000000  topcon      operational",
        "    0.000000  -           000#0105               NMT operational, node 5",
    ]


def test_quietly_what_is_as_usual_is_left_out(told):
    lines = told("605#4000100000000000", REFUSED, quiet=True, fault="interlock_open")
    assert [line[26:].partition("  ")[0] for line in lines if "why" not in line] == [
        "pre-operational",
        "585#8014200030000906",
        "085#009081F200000000",
    ]


def test_colours_tell_refusals_emergencies_and_states_apart(told):
    lines = told(REFUSED, coloured=True, fault="interlock_open")
    assert [line[:5] for line in lines] == [
        "\x1b[36m",
        "    0",
        "    0",
        "\x1b[31m",
        "\x1b[31m",
        "\x1b[33m",
    ]
    assert lines[-1].endswith("\x1b[0m")


@pytest.mark.parametrize(
    ("environment", "coloured"),
    [({}, True), ({"NO_COLOR": "1"}, False), ({"NO_COLOR": ""}, True), ({"TERM": "dumb"}, False)],
)
def test_there_are_colours_on_a_terminal_for_those_who_want_them(environment, coloured):
    stream = io.StringIO()
    assert not is_coloured(stream, environment)
    stream.isatty = lambda: True
    assert is_coloured(stream, environment) == coloured


def test_who_does_not_read_holds_no_twin_up():
    read, write = os.pipe()
    with os.fdopen(read) as reader, os.fdopen(write, "w") as writer:
        printer = Printer(writer)
        printer.start()
        for _ in range(MOST_WAITING + 2000):
            printer.put("x" * 100)
        printer.close(patience=0.01)
        lost = next(line for line in reader if not line.startswith("xxx"))
    assert re.fullmatch(r"\d+ lines were not read in time, and are lost\n", lost)


STORY = """\
version: 1
node: {device: topcon, node_id: 5}
steps:
  - {at: 0, inject: interlock_open}
  - {at: 0, expect: {emcy: any, within: 1}}
"""


def test_a_run_says_its_words_below_its_ready_line(tmp_path, capfd):
    (tmp_path / "story.yaml").write_text(STORY)
    run = ["run", "-i", "virtual", "--scenario", str(tmp_path / "story.yaml"), "--words"]
    assert main(run) == 0
    ready, *words = capfd.readouterr().out.splitlines()
    assert json.loads(ready)["ready"] == "topcon"
    assert words[0].endswith("  topcon      pre-operational")
    assert any("fault interlock_open() injected" in line for line in words)
    assert main([*run, "--json"]) == 0
    out, err = capfd.readouterr()
    assert [json.loads(line) and "" for line in out.splitlines()] == ["", ""]
    assert "boot-up" in err


def test_a_trace_of_a_run_is_written_as_it_goes_and_its_state_is_told_when_asked(tmp_path):
    trace = tmp_path / "live.log"
    run = [*PROGRAM, "run", "topcon", "-n", "5", "-i", "virtual", "--trace", str(trace)]
    with subprocess.Popen(
        run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        process.stdout.readline()
        assert "705#00" in trace.read_text()
        process.send_signal(signal.SIGUSR1)
        told = [process.stderr.readline() for _ in range(4)]
        process.terminate()
        assert process.wait(PATIENCE) == 0
    assert re.fullmatch(r"\d+\.\d{6} s\n", told[0])
    assert "".join(told[1:]) == "topcon: node 5, PRE-OPERATIONAL\n  faults: none\n  state: READY\n"
