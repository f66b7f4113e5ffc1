"""What a trace does not tell of a node: why it refused, what struck its frames, when it changed.

It is bounded, and written only where something is out of the ordinary: a frame that is taken or
answered as usual costs nothing.
"""

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from math import inf
from typing import Any, NamedTuple

import canopen

from canopen_twins.bus.clock import Timer, Timing
from canopen_twins.bus.frame import STANDARD_IDS, Frame

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


class PeriodicFrame:
    """What canopen calls a periodic task: a timer of the clock, not a thread."""

    def __init__(
        self, clock: Timing, period: float, frame: Frame, send: Callable[[Frame], None]
    ) -> None:
        self._frame = frame
        self._timer: Timer = clock.every(period, lambda: send(self._frame))

    def update(self, data: bytes) -> None:
        """Send other data from the next period on."""
        self._frame = self._frame._replace(data=bytes(data))

    def stop(self) -> None:
        """Send no more."""
        self._timer.cancel()


Onward = Callable[[Frame], None]

Filter = Callable[[Frame, Onward], None]
"""Gets a frame on its way and sends it onward: as it is or altered, now or later, or not at all."""


def through(filters: Sequence[Filter], frame: Frame, end: Onward) -> None:
    """Send a frame through filters, each to the next, the last to the end."""
    if filters:
        filters[0](frame, partial(through, filters[1:], end=end))
    else:
        end(frame)


Outbox = deque[tuple["Wire", Frame]]


class Wire(canopen.Network):
    """A `canopen.Network` whose bus is an outbox: whatever canopen sends goes the same way as ours.

    Several wires may share one outbox, so that the order in which their frames were sent is kept.
    """

    def __init__(self, clock: Timing, outbox: Outbox | None = None, name: str = "") -> None:
        super().__init__()
        self.clock = clock
        self.name = name
        self.shut = False  # off the bus for a while: nothing goes out, nothing comes in
        self.diary = Diary(clock)
        self.outgoing: list[Filter] = []
        self.incoming: list[Filter] = []
        self.outbox: Outbox = deque() if outbox is None else outbox

    def put(self, frame: Frame) -> None:
        """Send a frame."""
        if self.outgoing and not self.shut:
            through(self.outgoing, frame, self._send)
        elif not self.shut:
            self.outbox.append((self, frame))

    def _send(self, frame: Frame) -> None:
        if not self.shut:
            self.outbox.append((self, frame))

    def send_message(self, can_id: int, data: Sequence[int], remote: bool = False) -> None:
        """What canopen calls to send."""
        self.put(Frame(can_id, bytes(data), remote, can_id not in STANDARD_IDS))

    def send_periodic(
        self, can_id: int, data: Sequence[int], period: float, remote: bool = False
    ) -> Any:
        """What canopen calls to send again and again, every `period` seconds."""
        frame = Frame(can_id, bytes(data), remote, can_id not in STANDARD_IDS)
        return PeriodicFrame(self.clock, period, frame, self.put)
