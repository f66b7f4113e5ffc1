"""What a thread waits with, in simulated time: what `threading`, `queue` and `time` have.

Only one thread runs at a time, so none of it needs a lock of its own.
"""

import queue
import sched
import threading
import time
from collections.abc import Callable
from functools import partial
from threading import get_ident
from types import TracebackType
from typing import Any, NamedTuple, TypeVar

from canopen_twins.bench.limits import HangError, place_of
from canopen_twins.bench.simulated_time.scheduler import (
    TICK,
    Scheduler,
    Task,
    changed,
    in_force,
    wait,
)

T = TypeVar("T")

EPOCH = 946_684_800  # `time.time()` when the bench was made, so that every run has the same dates
NANOSECONDS = 1_000_000_000
OWN_LOCK = 60.0  # simulated seconds a thread waits for a lock that it holds itself


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
            if not blocking:
                return False
            if timeout < 0:
                self._wait_without_end()
            elif not wait(self._free, timeout):
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

    def release_save(self) -> Held:
        """Release it as often as it was acquired; what `acquire_restore` takes."""
        held, self._held = self._held, NOBODY
        changed()
        return held

    def acquire_restore(self, held: Held) -> None:
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

    def _wait_without_end(self) -> None:
        scheduler, me = in_force(), get_ident()
        scheduler.wanted_locks[me] = self
        try:
            holder = self._held.owner
            if holder == me:  # another one may release it, as those do who signal with locks
                if not wait(self._free, OWN_LOCK):
                    told = f"waits for a lock that it holds itself, at {place_of(me)}"
                    raise scheduler.refusal(f"a deadlock: a thread {told}", HangError)
                return
            if me in (ring := _ring(scheduler, holder)):
                places = " and ".join(place_of(each) for each in ring)
                told = f"a deadlock of threads that hold each other up: {places}"
                raise scheduler.refusal(told, HangError)
            wait(self._free)
        finally:
            del scheduler.wanted_locks[me]

    def _free(self) -> bool:
        return not self.locked()

    def _mine(self) -> bool:
        return False


def _ring(scheduler: Scheduler, thread: int) -> list[int]:
    """A thread, who holds the lock it waits for, and so on, as far as they wait without end."""
    threads = [thread]
    while isinstance(lock := scheduler.wanted_locks.get(thread), Lock):
        thread = lock._held.owner  # noqa: SLF001 - of our own kind
        if thread in threads:
            break
        threads.append(thread)
    return threads


class RLock(Lock):
    """As `threading.RLock`."""

    def release(self) -> None:
        """See `threading.RLock`."""
        if not self._mine():
            raise RuntimeError("cannot release un-acquired lock")
        super().release()

    def _mine(self) -> bool:
        return self.locked() and self._held.owner == get_ident()


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
        held = self._lock.release_save()
        try:
            return wait(lambda: ticket not in self._waiting, timeout)
        finally:
            if ticket in self._waiting:
                self._waiting.remove(ticket)
            self._lock.acquire_restore(held)

    def wait_for(self, predicate: Callable[[], T], timeout: float | None = None) -> T:
        """See `threading.Condition`."""
        clock = in_force().clock
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


class Queue(queue.Queue[Any]):
    """As `queue.Queue`."""

    def put(self, item: Any, block: bool = True, timeout: float | None = None) -> None:
        """See `queue.Queue`."""
        if block and self.full():
            wait(lambda: not self.full(), timeout)
        super().put(item, block=False)
        changed()

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        """See `queue.Queue`."""
        if block and self.empty():
            wait(lambda: not self.empty(), timeout)
        item = super().get(block=False)
        changed()
        return item

    def task_done(self) -> None:
        """See `queue.Queue`."""
        super().task_done()
        changed()

    def join(self) -> None:
        """See `queue.Queue`."""
        if self.unfinished_tasks:
            wait(lambda: not self.unfinished_tasks)


class LifoQueue(Queue, queue.LifoQueue[Any]):
    """As `queue.LifoQueue`."""


class PriorityQueue(Queue, queue.PriorityQueue[Any]):
    """As `queue.PriorityQueue`."""


class SimpleQueue(Queue):
    """As `queue.SimpleQueue`, which has no size."""

    def __init__(self) -> None:
        super().__init__()


class Thread(threading.Thread):
    """As `threading.Thread`; it ends with simulated time, if not before."""

    _task: Task | None = None

    def start(self) -> None:
        """See `threading.Thread`."""
        if self._task is not None:
            raise RuntimeError("threads can only be started once")
        scheduler = in_force()
        self.daemon = True  # one that cannot be ended does not keep the interpreter from ending
        self._task = scheduler.add(self)
        self.run = partial(scheduler.run_task, self._task, self.run)  # type: ignore[method-assign]
        super().start()

    def join(self, timeout: float | None = None) -> None:
        """See `threading.Thread`."""
        if self._task is None:
            raise RuntimeError("cannot join thread before it is started")
        if self is threading.current_thread():
            raise RuntimeError("cannot join current thread")
        if self.is_alive():
            wait(lambda: not self.is_alive(), timeout)

    def is_alive(self) -> bool:
        """See `threading.Thread`."""
        return self._task is not None and not self._task.done


class Timer(Thread, threading.Timer):
    """As `threading.Timer`."""

    def __init__(self, *arguments: Any, **keywords: Any) -> None:
        super().__init__(*arguments, **keywords)
        self.finished = Event()  # type: ignore[assignment]


class WallClock:
    """As the clocks of `time` and its `sleep`."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler

    def now(self) -> float:
        """Seconds of the bench's clock.

        Raises:
            SimulatedTimeError: somebody asks again and again and never waits.
        """
        self._scheduler.count("asks for the time")
        return self._scheduler.clock.now

    def sleep(self, seconds: float) -> None:
        """See `time.sleep`."""
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        self._scheduler.wait(lambda: False, max(seconds, TICK))  # a loop around sleep(0) goes on

    def date(self) -> float:
        """See `time.time`."""
        return EPOCH + self.now()

    def functions(self) -> dict[str, Callable[..., object]]:
        """The functions of `time` by their names."""
        return {
            "sleep": self.sleep,
            "time": self.date,
            "time_ns": lambda: round(self.date() * NANOSECONDS),
            "monotonic": self.now,
            "monotonic_ns": lambda: round(self.now() * NANOSECONDS),
            "perf_counter": self.now,
            "perf_counter_ns": lambda: round(self.now() * NANOSECONDS),
            "localtime": self._local,
            "gmtime": lambda seconds=None: time.gmtime(self._or_now(seconds)),
            "ctime": lambda seconds=None: time.ctime(self._or_now(seconds)),
            "asctime": lambda told=None: time.asctime(told or self._local()),
            "strftime": lambda text, told=None: time.strftime(text, told or self._local()),
            "clock_gettime": self._clock,
            "clock_gettime_ns": lambda clock: round(self._clock(clock) * NANOSECONDS),
        }

    def scheduler(self) -> type[sched.scheduler]:
        """`sched.scheduler`, which has the clock of the day it was made as its default."""
        wall = self

        class EventScheduler(sched.scheduler):
            """Waits in simulated time, unless it is told how to wait."""

            def __init__(
                self,
                timefunc: Callable[[], float] = wall.now,
                delayfunc: Callable[[float], object] = wall.sleep,
            ) -> None:
                super().__init__(timefunc, delayfunc)

        return EventScheduler

    def _local(self, seconds: float | None = None) -> time.struct_time:
        return time.localtime(self._or_now(seconds))

    def _clock(self, clock: int) -> float:
        """Those that tell what a process has used are of the real world."""
        if clock == time.CLOCK_REALTIME:
            return self.date()
        names = ("CLOCK_MONOTONIC", "CLOCK_MONOTONIC_RAW", "CLOCK_BOOTTIME")
        if clock in {getattr(time, name, None) for name in names}:
            return self.now()
        return time.clock_gettime(clock)

    def _or_now(self, seconds: float | None) -> float:
        return self.date() if seconds is None else seconds
