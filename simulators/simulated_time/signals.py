"""`threading.Condition`, `Event` and `Semaphore` in simulated time."""

from collections.abc import Callable
from types import TracebackType
from typing import TypeVar

from simulators.simulated_time.in_force import baton, changed, wait
from simulators.simulated_time.locks import Lock, RLock

T = TypeVar("T")


class Condition:
    """As `threading.Condition`."""

    def __init__(self, lock: Lock | None = None) -> None:
        self._lock = RLock() if lock is None else lock
        self._waiting: list[object] = []  # in the order in which they came
        self.acquire = self._lock.acquire
        self.release = self._lock.release

    def wait(self, timeout: float | None = None) -> bool:
        """See `threading.Condition`."""
        self._must_be_held()
        ticket = object()
        self._waiting.append(ticket)
        held = self._lock.give_up()
        try:
            return wait(lambda: ticket not in self._waiting, timeout)
        finally:
            if ticket in self._waiting:
                self._waiting.remove(ticket)
            self._lock.take_back(held)

    def wait_for(self, predicate: Callable[[], T], timeout: float | None = None) -> T:
        """See `threading.Condition`."""
        clock = baton().clock
        end = None if timeout is None else clock.now + timeout
        while not (result := predicate()) and (end is None or clock.now < end):
            self.wait(None if end is None else end - clock.now)
        return result

    def notify(self, n: int = 1) -> None:
        """See `threading.Condition`."""
        self._must_be_held()
        del self._waiting[:n]
        changed()

    def notify_all(self) -> None:
        """See `threading.Condition`."""
        self.notify(len(self._waiting))

    def __enter__(self) -> bool:
        return self._lock.__enter__()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._lock.release()

    def _must_be_held(self) -> None:
        if not self._lock.locked():
            raise RuntimeError("the lock of a condition must be held")


class Event:
    """As `threading.Event`."""

    def __init__(self) -> None:
        self._flag = False

    def is_set(self) -> bool:
        """See `threading.Event`."""
        return self._flag

    def set(self) -> None:
        """See `threading.Event`."""
        self._flag = True
        changed()

    def clear(self) -> None:
        """See `threading.Event`."""
        self._flag = False

    def wait(self, timeout: float | None = None) -> bool:
        """See `threading.Event`."""
        return self._flag or wait(self.is_set, timeout)


class Semaphore:
    """As `threading.Semaphore`."""

    def __init__(self, value: int = 1) -> None:
        self._value = value

    def acquire(self, blocking: bool = True, timeout: float | None = None) -> bool:
        """See `threading.Semaphore`."""
        if not self._value and not (blocking and wait(lambda: self._value, timeout)):
            return False
        self._value -= 1
        return True

    def release(self, n: int = 1) -> None:
        """See `threading.Semaphore`."""
        self._value += n
        changed()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.release()


class BoundedSemaphore(Semaphore):
    """As `threading.BoundedSemaphore`."""

    def __init__(self, value: int = 1) -> None:
        super().__init__(value)
        self._bound = value

    def release(self, n: int = 1) -> None:
        """See `threading.BoundedSemaphore`."""
        if self._value + n > self._bound:
            raise ValueError("Semaphore released too many times")
        super().release(n)
