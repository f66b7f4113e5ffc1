"""`threading.Lock` and `RLock` in simulated time.

Only one thread runs at a time, and nothing interrupts it but its own waits: plain attributes do
for what needs atomic operations elsewhere.
"""

from threading import get_ident
from types import TracebackType
from typing import NamedTuple

from simulators.simulated_time.in_force import changed, wait


class Held(NamedTuple):
    """How a lock is held."""

    owner: int
    depth: int


NOBODY = Held(0, 0)


class Lock:
    """As `threading.Lock`."""

    def __init__(self) -> None:
        self._held = NOBODY

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """See `threading.Lock`."""
        if self.locked() and not self._mine():
            longest = None if timeout < 0 else timeout
            if not (blocking and wait(self._free, longest)):
                return False
        self._held = Held(get_ident(), self._held.depth + 1)
        return True

    def release(self) -> None:
        """See `threading.Lock`."""
        if not self.locked():
            raise RuntimeError("release unlocked lock")
        self._held = self._held._replace(depth=self._held.depth - 1)
        changed()

    def locked(self) -> bool:
        """See `threading.Lock`."""
        return self._held.depth > 0

    def give_up(self) -> Held:
        """Release it as often as it was acquired; what `take_back` wants."""
        held, self._held = self._held, NOBODY
        changed()
        return held

    def take_back(self, held: Held) -> None:
        """Hold it as before, even if the wait for it is cut short: its owner will release it."""
        try:
            if self.locked():
                wait(self._free)
        finally:
            self._held = held

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.release()

    def _free(self) -> bool:
        return not self.locked()

    def _mine(self) -> bool:
        return False


class RLock(Lock):
    """As `threading.RLock`."""

    def release(self) -> None:
        """See `threading.RLock`."""
        if not self._mine():
            raise RuntimeError("cannot release un-acquired lock")
        super().release()

    def _mine(self) -> bool:
        return self.locked() and self._held.owner == get_ident()
