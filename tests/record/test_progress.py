import sys
from io import StringIO

import pytest

from canopen_twins import scenario as replay
from canopen_twins.cli import main
from canopen_twins.cli.play import ProgressLine

LONG = """\
version: 1
node: {device: topcon, node_id: 5}
duration: 20
steps:
  - {at: 0.1, write: {Producer Heartbeat Time: 1000}}
"""


class Terminal(StringIO):
    def isatty(self):
        return True


def told(stream):
    """What could be read one after the other where it was written."""
    return [part.strip() for part in stream.getvalue().split("\r") if part]


@pytest.fixture
def line():
    """A line for a run of 20 s, each second of which takes `pace` seconds of real time."""

    def run(story, pace):
        seen, wall = Terminal(), [0.0]
        line = ProgressLine(seen, lambda: wall[0])

        def tell(now):
            wall[0] = now * pace
            line.tell(now)

        replay.play(replay.load(story(LONG)), observers=[line.attach], progress=tell)
        line.close()
        return seen

    return run


def test_a_line_is_written_each_half_second_and_cleared_at_the_end(line, story):
    seen = line(story, 0.09)
    assert told(seen) == [f"{now} of 20 s simulated" for now in (6, 12, 18)] + [""]
    assert "\n" not in seen.getvalue()


def test_a_short_run_writes_nothing(line, story):
    assert line(story, 0.001).getvalue() == ""


@pytest.mark.parametrize(
    ("out", "err", "shown"),
    [(StringIO, Terminal, True), (Terminal, Terminal, False), (StringIO, StringIO, False)],
)
def test_only_a_terminal_that_shows_nothing_else_has_the_line(monkeypatch, story, out, err, shown):
    monkeypatch.setattr("canopen_twins.cli.play.PERIOD", 0.0)
    monkeypatch.setattr(sys, "stdout", out())
    monkeypatch.setattr(sys, "stderr", err())
    monkeypatch.setattr(sys.stdout, "fileno", lambda: 1, raising=False)
    assert main(["play", str(story(LONG))]) == 0
    assert bool(sys.stderr.getvalue()) == shown
    assert told(sys.stderr)[-1:] == [""] * shown
