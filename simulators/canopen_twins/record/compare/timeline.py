"""The time of a trace, and the twins' own: simulated, behind the trace by what they waited for."""

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node

LONGEST_GAP = 600 * MICROSECONDS  # without a frame; what is longer is a pause of the recording
LONGEST_WAIT = 60.0  # seconds for a twin to boot


class Timeline:
    """`now` is in microseconds from the first frame of the trace on; pauses are left out."""

    def __init__(self, segment: Segment[Node]) -> None:
        self.segment = segment
        self.now = 0
        self.left_out: list[str] = []
        """Pauses and leaps, in words."""
        self._origin: int | None = None
        self._lag = 0
        self._next = 0  # where time is let pass to

    @property
    def clock(self) -> int:
        """Microseconds of the twins."""
        return self.segment.clock.ticks

    @property
    def of_twins(self) -> int:
        """What time of the trace it is for the twins; they wait for nothing in its future."""
        return min(self.segment.clock.ticks - self._lag, self._next)

    def relative(self, tick: int) -> int:
        """A time of the trace from its first frame on."""
        return 0 if self._origin is None else tick - self._origin

    def advance(self, tick: int) -> int:
        """Let time pass for the twins up to a frame of the trace; its time from the first on."""
        if self._origin is None:
            self._origin = tick
        now = tick - self._origin
        step = now - self.now
        if not 0 <= step <= LONGEST_GAP:
            now = self._leap(step)
        if now != self._next:
            self._next = now
            self.segment.advance_to((now + self._lag) / MICROSECONDS)
        self.now = now
        return now

    def _leap(self, step: int) -> int:
        """Take over another time without letting it pass."""
        assert self._origin is not None
        if step > 0 or step < -MICROSECONDS:
            where = f"{self.now / MICROSECONDS:.6f} s"
            told = (
                f"{step / MICROSECONDS:.6f} s are left out"
                if step > 0
                else (f"the time goes back by {-step / MICROSECONDS:.6f} s")
            )
            self.left_out.append(f"after {where} {told}")
            self._origin += step
        return self.now

    def wait_for(self, node: Node) -> bool:
        """Let a node boot while the trace stands still; whether it has."""
        clock = self.segment.clock
        end, begun = clock.now + LONGEST_WAIT, clock.ticks
        while node.slave is None and clock.next_deadline <= end:
            self.segment.advance_to(clock.next_deadline)
        self._lag += clock.ticks - begun
        return node.slave is not None
