"""Messages that come by themselves: each of the trace is matched with one of the twin.

They are matched, not counted off: one that is lacking on a side shifts nothing. What has the same
content at the same time belongs together at once, whatever lies between; the rest is decided when
nothing better can come any more.
"""

from collections import deque
from collections.abc import Callable, Sequence
from itertools import islice
from math import inf
from typing import NamedTuple

from canopen_twins.bus.frame import Frame

AHEAD = 8  # messages that are looked at on either side
WINDOW = 1_000_000  # microseconds; what is further apart does not belong together


class Seen(NamedTuple):
    """A message and its moment."""

    tick: int
    """Microseconds of the trace."""
    frame: Frame
    also: Sequence[bytes] = ()
    """Of the device: what the twin would have sent at this very moment, and a little later."""


class Pair(NamedTuple):
    """A message of the trace and the one of the twin; one of them may lack."""

    device: Seen | None
    twin: Seen | None
    late: int = 0
    """Microseconds that the device's is later than it should be; negative: earlier."""
    intervals: tuple[int, int] | None = None
    """From the pair before, on either side, in microseconds."""


class Stream:
    """The messages of one service of a node, in their order."""

    def __init__(
        self,
        tolerance: int,
        same: Callable[[Seen, Seen], bool],
        judge: Callable[[Pair], None],
    ) -> None:
        """`tolerance` in microseconds; `judge` is called with each pair, once."""
        self._tolerance = tolerance
        self._same = same
        self._judge = judge
        self._device: deque[Seen] = deque()
        self._twin: deque[Seen] = deque()
        self._offset = 0  # of the device's last message from the twin's
        self._base = 0
        self._last: tuple[Seen, Seen] | None = None
        self.free = False
        """Whether the next pair says what the offset is: what came before is not known."""

    def add_device(self, seen: Seen) -> None:
        """The device has sent one."""
        self._device.append(seen)
        if self._twin:
            self._match()

    def add_twin(self, seen: Seen) -> None:
        """The twin has sent one."""
        self._twin.append(seen)
        if self._device:
            self._match()

    @property
    def pending(self) -> bool:
        """Whether something waits for its counterpart."""
        return bool(self._device or self._twin)

    def settle(self, now: float) -> None:
        """Decide what is so old that nothing better comes any more; `now` in microseconds."""
        while self.pending:
            device, twin = self._heads()
            oldest = min(
                each for each in (device, twin and twin + self._offset) if each is not None
            )
            if now - oldest <= WINDOW:
                return
            if device is None or twin is None:
                self._alone(of_device=twin is None)
            elif self.free or abs(device - twin - self._offset) <= WINDOW:
                self._pair(self._device.popleft(), self._twin.popleft())
            else:
                self._alone(of_device=device < twin + self._offset)

    def forget(self) -> None:
        """Begin anew: what waits has no counterpart that comes at a time of its own."""
        self._device.clear()
        self._twin.clear()
        self._last = None
        self.free = True

    def end(self, now: int) -> None:
        """Decide all; the counterpart of what came last may only have been due after the end."""
        latest = now - self._tolerance
        while self._device and self._device[-1].tick - self._offset > latest and not self._twin:
            self._device.pop()
        while self._twin and self._twin[-1].tick + self._offset > latest and not self._device:
            self._twin.pop()
        self.settle(inf)

    def _heads(self) -> tuple[int | None, int | None]:
        device = self._device[0].tick if self._device else None
        return device, self._twin[0].tick if self._twin else None

    def _match(self) -> None:
        """Take out what belongs together beyond doubt, and what lies before it."""
        while self._device and self._twin:
            device, twin = self._device[0], self._twin[0]
            for place, other in enumerate(islice(self._twin, AHEAD)):
                if self._fits(device, other):
                    self._take(0, place)
                    break
            else:
                for place, other in enumerate(islice(self._device, AHEAD)):
                    if self._fits(other, twin):
                        self._take(place, 0)
                        break
                else:
                    return

    def _take(self, devices: int, twins: int) -> None:
        for _ in range(devices):
            self._alone(of_device=True)
        for _ in range(twins):
            self._alone(of_device=False)
        self._pair(self._device.popleft(), self._twin.popleft())

    def _fits(self, device: Seen, twin: Seen) -> bool:
        if abs(self._late(device, twin)) > self._tolerance:
            return False
        return device.frame == twin.frame or self._same(device, twin)

    def _late(self, device: Seen, twin: Seen) -> int:
        """As little as the absolute time, or that from the pair before, has it."""
        if self.free:
            return 0
        apart = device.tick - twin.tick
        return min(apart - self._base, apart - self._offset, key=abs)

    def _pair(self, device: Seen, twin: Seen) -> None:
        late = self._late(device, twin)
        self._offset = device.tick - twin.tick
        if self.free:
            self.free, self._base = False, self._offset
        intervals = None
        if self._last is not None:
            intervals = device.tick - self._last[0].tick, twin.tick - self._last[1].tick
        self._last = device, twin
        self._judge(Pair(device, twin, late, intervals))

    def _alone(self, of_device: bool) -> None:
        if of_device:
            self._judge(Pair(self._device.popleft(), None))
        else:
            self._judge(Pair(None, self._twin.popleft()))
