"""The one door through which a node sends its frames; nothing behind it is threaded."""

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import canopen

from simulators.clock import Timer, Timing
from simulators.diary import Diary
from simulators.frame import STANDARD_IDS, Frame


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
