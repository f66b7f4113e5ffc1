"""Frames, and the one door through which a node sends them; nothing behind it is threaded."""

import re
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import canopen

from simulators.clock import Timer, Timing
from simulators.diary import Diary
from simulators.errors import UserError

LONGEST = 8  # data bytes of a classic CAN frame
STANDARD_IDS = range(0x800)
ANY_DIGIT, ANY_REST = "X", "*"
NOTATION = re.compile(r"(?P<id>[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(?P<rest>R[0-8]?|[0-9A-Fa-f.]*)")


class Frame(NamedTuple):
    """One CAN frame."""

    can_id: int
    data: bytes = b""
    remote: bool = False
    extended: bool = False

    @classmethod
    def parse(cls, text: str) -> "Frame":
        """Read the notation of `cansend`: 605#40.20.20.00, 185#R; eight digits are a 29-bit id.

        Raises:
            UserError: the text is no frame.
        """
        if not (match := NOTATION.fullmatch(text.strip())):
            raise UserError(f"{text!r} is no frame: write ID#DATA or ID#R, such as 605#4000100000")
        can_id, extended = int(match["id"], 16), len(match["id"]) == 8
        if can_id >= (1 << 29 if extended else 1 << 11):
            raise UserError(f"{text!r}: identifiers end at {'1FFFFFFF' if extended else '7FF'}")
        if match["rest"].startswith("R"):
            return cls(can_id, remote=True, extended=extended)
        return cls(can_id, _payload(text, match["rest"].replace(".", "")), extended=extended)

    def __str__(self) -> str:
        can_id = f"{self.can_id:08X}" if self.extended else f"{self.can_id:03X}"
        return f"{can_id}#{'R' if self.remote else self.data.hex().upper()}"


def _payload(text: str, digits: str) -> bytes:
    if len(digits) % 2 or len(digits) > 2 * LONGEST:
        raise UserError(f"{text!r}: data are at most {LONGEST} bytes of two hex digits each")
    return bytes.fromhex(digits)


def pattern(text: str) -> re.Pattern[str]:
    """Matches `str(frame)`: the notation of `cansend`, x for any digit, * at the end for any rest.

    Raises:
        UserError: the text is no frame with an x for some of its digits.
    """
    plain = text.strip().replace(".", "").upper()
    zeros = plain.removesuffix(ANY_REST).replace(ANY_DIGIT, "0")
    try:
        Frame.parse(zeros)
    except UserError as refusal:  # tell it of what was written
        raise UserError(str(refusal).replace(repr(zeros), repr(text))) from None
    return re.compile(plain.replace(ANY_DIGIT, "[0-9A-F]").replace(ANY_REST, ".*"))


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
