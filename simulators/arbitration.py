"""A bus whose frames take their time: one after the other, the lowest identifier first."""

from collections import deque
from heapq import heappop, heappush
from itertools import count

from simulators.bits import length
from simulators.clock import Clock
from simulators.frame import Frame
from simulators.wire import Outbox, Wire


class Arbitration:
    """Frames that wait compete for the bus each time it is free; equals keep their order.

    What is over is in `arrived`, with who sent it; the bit rate is in bit/s.
    """

    def __init__(self, clock: Clock, bit_rate: int) -> None:
        self.bit_rate = bit_rate
        self._clock = clock
        self.arrived: Outbox = deque()
        self._waiting: list[tuple[tuple[int, ...], int, Wire, Frame]] = []
        self._order = count()
        self._busy = False

    def take(self, outbox: Outbox) -> None:
        """Let everything compete that has been sent by now."""
        while outbox:
            sender, frame = outbox.popleft()
            heappush(self._waiting, (priority(frame), next(self._order), sender, frame))
        if self._waiting and not self._busy:
            self._begin()

    def _begin(self) -> None:
        _, _, sender, frame = heappop(self._waiting)
        self._busy = True
        self._clock.after(length(frame) / self.bit_rate, lambda: self._end(sender, frame))

    def _end(self, sender: Wire, frame: Frame) -> None:
        self._busy = False
        self.arrived.append((sender, frame))


def priority(frame: Frame) -> tuple[int, ...]:
    """The bits of the arbitration field in their order; the lower one wins (ISO 11898-1)."""
    if frame.extended:
        return (frame.can_id >> 18, 1, 1, frame.can_id & 0x3FFFF, frame.remote)
    return (frame.can_id, frame.remote, 0)
