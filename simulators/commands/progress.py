"""How far a long run has come: one line on a terminal, and nothing anywhere else."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

PERIOD = 0.5  # seconds of real time from one line to the next
WIDTH = 60

Tell = Callable[[float], None]
"""Takes the simulated time in seconds, as often as one likes."""


@contextmanager
def progress(total: float) -> Iterator[Tell]:
    """Tells on stderr how much of `total` seconds is over; 0 if nobody knows how long it takes.

    The line is there only if people see it alone: stderr is a terminal and stdout is not.
    """
    if not sys.stderr.isatty() or sys.stdout.isatty():
        yield lambda now: None
        return
    line = Line(sys.stderr, total)
    try:
        yield line.tell
    finally:
        line.clear()


class Line:
    """One line that is written again and again."""

    def __init__(
        self, stream: TextIO, total: float, wall: Callable[[], float] = time.monotonic
    ) -> None:
        self._stream = stream
        self._of = f" of {total:.0f}" if total else ""
        self._wall = wall
        self._due = wall() + PERIOD
        self._written = False

    def tell(self, now: float) -> None:
        """Write it anew, if it is time to."""
        if self._wall() < self._due:
            return
        self._due = self._wall() + PERIOD
        self._written = True
        self._write(f"{now:.0f}{self._of} s simulated")

    def clear(self) -> None:
        """Leave nothing of it."""
        if self._written:
            self._write("")

    def _write(self, text: str) -> None:
        self._stream.write(f"\r{text:{WIDTH}}\r")
        self._stream.flush()
