import sys
from io import StringIO

import pytest

from simulators.commands.progress import Line, progress


class Terminal(StringIO):
    def isatty(self):
        return True


def test_a_line_is_written_each_half_second_and_cleared_at_the_end():
    seen, wall = Terminal(), [0.0]
    line = Line(seen, 1200, lambda: wall[0])
    for _ in range(5):
        wall[0] += 0.25
        line.tell(wall[0] * 100)
    line.clear()
    told = [part.strip() for part in seen.getvalue().split("\r") if part]
    assert told == ["50 of 1200 s simulated", "100 of 1200 s simulated", ""]
    assert "\n" not in seen.getvalue()


def test_a_run_of_unknown_length_tells_what_is_over():
    seen, wall = Terminal(), [0.0]
    line = Line(seen, 0, lambda: wall[0])
    wall[0] = 1.0
    line.tell(12.3)
    assert seen.getvalue().strip() == "12 s simulated"


def test_a_short_run_writes_nothing():
    seen = Terminal()
    line = Line(seen, 1200, lambda: 0.0)
    line.tell(1200)
    line.clear()
    assert seen.getvalue() == ""


@pytest.mark.parametrize(
    ("out", "err", "lines"),
    [(StringIO, Terminal, 2), (Terminal, Terminal, 0), (StringIO, StringIO, 0)],
)
def test_only_a_terminal_that_shows_nothing_else_has_the_line(monkeypatch, out, err, lines):
    monkeypatch.setattr("simulators.commands.progress.PERIOD", 0.0)
    monkeypatch.setattr(sys, "stdout", out())
    monkeypatch.setattr(sys, "stderr", err())
    with progress(10) as tell:
        tell(3)
    assert sys.stderr.getvalue().count("\r") == 2 * lines
