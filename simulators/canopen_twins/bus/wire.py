"""A node's end of a bus: where its frames go out, through which filters, and its event log."""

from collections import deque
from collections.abc import Callable, Container, Iterable, Sequence
from enum import Enum
from functools import partial
from math import inf
from typing import Any, NamedTuple

import canopen

from canopen_twins.bus.clock import Timer, Timing
from canopen_twins.bus.frame import STANDARD_IDS, Frame

KEPT = 64  # entries of a kind
NOT_BOOTED = ""  # the state before the first boot
GRAIN = 0.5e-6  # seconds: two times that differ by less are one moment of the clock


class ErrorState(Enum):
    """Of a CAN controller (ISO 11898-1)."""

    ACTIVE = "error active"
    PASSIVE = "error passive"
    BUS_OFF = "bus off"


class LogEntry(NamedTuple):
    """Something that happened to a node."""

    time: float
    """Seconds of the clock."""
    about: str
    """A frame in the notation of cansend, if it is about one."""
    words: str
    address: tuple[int, int] | None = None
    """The object it is about, where the frame does not tell."""


class EventLog:
    """What a trace does not tell of a node: why it refused, what struck its frames, its states.

    It is bounded, and written only where something is out of the ordinary: a frame that is taken
    or answered as usual costs nothing.
    """

    def __init__(self, clock: Timing) -> None:
        self.refusals: deque[LogEntry] = deque(maxlen=KEPT)
        """Why, with the SDO abort or the RPDO."""
        self.strikes: deque[LogEntry] = deque(maxlen=KEPT)
        """Names of faults, with the frames they struck."""
        self._states: deque[LogEntry] = deque([LogEntry(-inf, "", NOT_BOOTED)], maxlen=KEPT)
        self._clock = clock

    def add_refusal(
        self, frame: object, reason: object, address: tuple[int, int] | None = None
    ) -> None:
        """A value or an access has been refused."""
        self.refusals.append(LogEntry(self._clock.now, str(frame), str(reason), address))

    def add_strike(self, frame: object, fault: str) -> None:
        """A fault has struck a frame."""
        self.strikes.append(LogEntry(self._clock.now, str(frame), fault))

    def add_state(self, state: str) -> None:
        """The node has entered an NMT state."""
        self._states.append(LogEntry(self._clock.now, "", state))

    def states(self, time: float) -> set[str]:
        """The NMT states the node was in during a moment; empty if it is too long ago."""
        begun = [entry for entry in self._states if entry.time <= time + GRAIN]
        earlier = [entry for entry in begun if entry.time < time - GRAIN]
        during = begun[len(earlier) :]
        states = {entry.words for entry in [*earlier[-1:], *during]}
        return states - {NOT_BOOTED} or states  # the moment of a boot is one after it


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


Heard = tuple[int, bool]
"""An identifier, and whether frames with it are remote ones."""


class Outbox(deque[tuple["Wire", Frame]]):
    """What has been sent by the wires that share it, in its order, with who sent it."""

    __slots__ = ("hearers",)

    def __init__(self, sent: Iterable[tuple["Wire", Frame]] = ()) -> None:
        super().__init__(sent)
        self.hearers: dict[Heard, list[Any]] = {}
        """Which ends hear what, as far as their segment has looked since one listens otherwise."""


class Wire(canopen.Network):
    """A `canopen.Network` whose bus is an outbox: whatever canopen sends goes the same way as ours.

    Several wires may share one outbox, so that the order in which their frames were sent is kept.
    """

    def __init__(self, clock: Timing, outbox: Outbox | None = None, name: str = "") -> None:
        super().__init__()
        self.clock = clock
        self.name = name
        self.events = EventLog(clock)
        self.bit_rate: Callable[[], int | None] = lambda: None
        """In force, in bit/s; none fits any bus."""
        self.cut_off = ""
        """Why nothing gets through in either direction, in words; the segment says so."""
        self.outgoing: list[Filter] = []
        self.incoming: list[Filter] = []
        self.heard: Container[Heard] | None = None
        """All that its end listens to, none for whatever comes: most frames are for others."""
        self.error_state = ErrorState.ACTIVE  # a fault of the line says otherwise
        self.outbox = Outbox() if outbox is None else outbox

    def listen(self, heard: Container[Heard]) -> None:
        """Hear nothing but this from now on."""
        self.heard = heard
        self.outbox.hearers.clear()

    def filter_incoming(self, filters: Sequence[Filter]) -> None:
        """Let whatever comes go through these from now on, each to the next."""
        self.incoming = list(filters)
        self.outbox.hearers.clear()

    def hears(self, key: Heard) -> bool:
        """Whether a frame is for its end, or for a filter before that."""
        return self.heard is None or key in self.heard or bool(self.incoming)

    def put(self, frame: Frame) -> None:
        """Send a frame."""
        if self.outgoing:
            through(self.outgoing, frame, self._send)
        else:
            self.outbox.append((self, frame))

    def _send(self, frame: Frame) -> None:
        self.outbox.append((self, frame))

    def send_message(self, can_id: int, data: Sequence[int], remote: bool = False) -> None:
        """What canopen calls to send."""
        self.put(Frame(can_id, bytes(data), remote, can_id not in STANDARD_IDS))

    def send_periodic(
        self, can_id: int, data: Sequence[int] | None, period: float, remote: bool = False
    ) -> Any:
        """What canopen calls to send again and again, every `period` seconds."""
        frame = Frame(can_id, bytes(data or ()), remote, can_id not in STANDARD_IDS)
        return PeriodicFrame(self.clock, period, frame, self.put)
