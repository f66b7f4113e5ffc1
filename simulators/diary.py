"""What a trace does not tell of a node: why it refused, what struck its frames, when it changed.

It is bounded, and written only where something is out of the ordinary: a frame that is taken or
answered as usual costs nothing.
"""

from collections import deque
from math import inf
from typing import NamedTuple

from simulators.clock import Timing

KEPT = 64  # notes of a kind
UNBORN = ""  # the state before the first boot
GRAIN = 0.5e-6  # seconds: two times that differ by less are one moment of the clock


class Note(NamedTuple):
    """Something that happened to a node."""

    time: float
    """Seconds of the clock."""
    about: str
    """A frame in the notation of cansend, if it is about one."""
    words: str
    address: tuple[int, int] | None = None
    """The object it is about, where the frame does not tell."""


class Diary:
    """Whoever refuses, strikes or changes the state writes; a failure report reads."""

    def __init__(self, clock: Timing) -> None:
        self.refusals: deque[Note] = deque(maxlen=KEPT)
        """Why, with the SDO abort or the RPDO."""
        self.strikes: deque[Note] = deque(maxlen=KEPT)
        """Names of faults, with the frames they struck."""
        self._states: deque[Note] = deque([Note(-inf, "", UNBORN)], maxlen=KEPT)
        self._clock = clock

    def refuse(self, frame: object, reason: object, address: tuple[int, int] | None = None) -> None:
        """A value or an access has been refused."""
        self.refusals.append(Note(self._clock.now, str(frame), str(reason), address))

    def strike(self, frame: object, fault: str) -> None:
        """A fault has struck a frame."""
        self.strikes.append(Note(self._clock.now, str(frame), fault))

    def enter(self, state: str) -> None:
        """The node has entered an NMT state."""
        self._states.append(Note(self._clock.now, "", state))

    def states(self, time: float) -> set[str]:
        """The NMT states the node was in during a moment; empty if it is too long ago."""
        begun = [note for note in self._states if note.time <= time + GRAIN]
        earlier = [note for note in begun if note.time < time - GRAIN]
        during = begun[len(earlier) :]
        states = {note.words for note in [*earlier[-1:], *during]}
        return states - {UNBORN} or states  # the moment of a boot is one after it
