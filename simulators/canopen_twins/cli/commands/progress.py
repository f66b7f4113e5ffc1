"""How far a long run has come: one line on a terminal, and nothing anywhere else."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.scenario import Player

PERIOD = 0.5  # seconds of real time from one line to the next
WIDTH = 60


class Progress:
    """Says nothing."""

    def attach(self, segment: Segment[Node], player: Player) -> None:
        """A run begins."""

    def tell(self, now: float) -> None:
        """So many seconds of it are over; called as often as one likes."""


@contextmanager
def progress() -> Iterator[Progress]:
    """Tells on stderr how far a run has come, if that is a terminal and stdout is none.

    Where frames run over the same screen they say it themselves.
    """
    if not sys.stderr.isatty() or sys.stdout.isatty():
        yield Progress()
        return
    line = Line(sys.stderr)
    try:
        yield line
    finally:
        line.clear()


class Line(Progress):
    """One line that is written again and again; `wall` gives seconds of real time."""

    def __init__(self, stream: TextIO, wall: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._wall = wall
        self._due = wall() + PERIOD
        self._written = False
        self._player: Player | None = None

    def attach(self, segment: Segment[Node], player: Player) -> None:
        """It knows how long the run will be, as far as anybody does."""
        self._player = player

    def tell(self, now: float) -> None:
        """Write it anew, if it is time to."""
        if self._player is None or self._wall() < self._due:
            return
        self._due = self._wall() + PERIOD
        self._written = True
        total = max(now, self._player.horizon, self._player.scenario.duration or 0.0)
        self._write(f"{now:.0f} of {total:.0f} s simulated")

    def clear(self) -> None:
        """Leave nothing of it."""
        if self._written:
            self._write("")

    def _write(self, text: str) -> None:
        self._stream.write(f"\r{text:{WIDTH}}\r")
        self._stream.flush()
