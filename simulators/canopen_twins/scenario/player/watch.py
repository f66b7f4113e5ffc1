"""Watches for a sign: in what happens, or by looking at a node once a cycle of its device."""

from collections import deque
from collections.abc import Callable, Sequence

from canopen_twins.bus.clock import Clock, Timer
from canopen_twins.device.node import Node
from canopen_twins.scenario.matchers import Happening, Sign

GRAIN = 1  # microsecond: a moment of the clock is over when the next one begins
TOLD = 5  # things in one line


class Watch:
    """Tells `seen` once, in words, when all parts of a sign have been seen for the n-th time.

    Somebody else hands it what happens; looks at a node are its own. A sign that is looked for is
    seen at the first look at which it is there, and then again when it has been away.
    """

    def __init__(
        self,
        parts: Sequence[Sign],
        node: Node,
        clock: Clock,
        seen: Callable[[str], None],
        nth: int = 1,
    ) -> None:
        self._parts = parts
        self._node = node
        self._clock = clock
        self._seen = seen
        self._to_come = nth
        self._missing = list(parts)
        self._told: list[str] = []
        self._kin: deque[str] = deque(maxlen=TOLD)
        self._there = False
        self._timer: Timer | None = None
        self.over = False
        if parts[0].looks:
            self._timer = clock.at_tick(clock.ticks + GRAIN, self._look)

    def hear(self, happening: Happening) -> None:
        """Take something that has happened."""
        for part in self._missing:
            if not self.over and part.is_kin(happening, self._node):
                told = part.tell(happening)
                if part.sees(happening, self._node):
                    self._take(part, told)
                    return
                self._kin.append(told)

    def stop(self) -> None:
        """It does not matter any more."""
        self.over = True
        if self._timer is not None:
            self._timer.cancel()

    @property
    def now(self) -> tuple[bool, str]:
        """Whether the sign is there at a look, and how it looks; or what came instead of it."""
        if self._parts[0].looks:
            return self._parts[0].look(self._node)
        return False, f"only {', '.join(self._kin)}" if self._kin else "none came"

    def _take(self, part: Sign, told: str) -> None:
        self._missing = [other for other in self._missing if other is not part]
        self._told.append(told)
        if not self._missing:
            self._count(", ".join(self._told))

    def _count(self, told: str) -> None:
        self._to_come -= 1
        self._missing, self._told = list(self._parts), []
        if not self._to_come:
            self.stop()
            self._seen(told)

    def _look(self) -> None:
        there, told = self._parts[0].look(self._node)
        self._timer = self._clock.after(self._node.device.cycle, self._look)
        before, self._there = self._there, there
        if there and not before:
            self._count(told)
