"""Lets one thread of the master run at a time, and simulated time pass while all of them wait.

The thread that enters simulated time, as a rule that of a test, moves the clock of the bench
whenever it waits; timers of the clock resume the other threads, each until it waits again. So what
happens, and in which order, depends on the clock alone.
"""

import asyncio
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from canopen_twins.bench.limits import (
    HangError,
    OutOfTime,
    SimulatedTimeError,
    Standstill,
    place_of,
    raise_in,
)
from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node

Ready = Callable[[], object]
"""Whether what somebody waits for has come; asked by the thread that runs."""

TICK = 1 / MICROSECONDS  # seconds; who waits for less, as for a rest left by rounding, gets this
LONGEST = 86_400.0  # simulated seconds of a block
LONGEST_WAIT = 3600.0  # simulated seconds the test waits for what has no time-out of its own
MOST_STOPS = 100  # attempts to go on of a thread that has been told to end


class Stopped(BaseException):
    """Ends a thread of the master with simulated time; no `except Exception` holds it up."""


class Turn:
    """Whoever waits for it goes on when it is given: a semaphore, for less."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lock.acquire()
        self.wait = self._lock.acquire
        """As that of a lock, with its `timeout` in seconds of real time."""

    def give(self) -> None:
        """One that is given already stays so: that is after a limit has come in between."""
        with suppress(RuntimeError):
            self._lock.release()


class Task:
    """A thread of the master: what it waits for, and the turn that resumes it."""

    def __init__(self, thread: threading.Thread) -> None:
        self.thread = thread
        self.turn = Turn()
        self.ready: Ready = lambda: True
        self.done = False
        self._stops = 0

    def stop(self) -> None:
        """Called by the thread itself, in a wait.

        Raises:
            Stopped: always, but for a thread that has caught it again and again.
        """
        self._stops += 1
        if self._stops <= MOST_STOPS:
            raise Stopped

    def run(self, target: Callable[[], None]) -> BaseException | None:
        """Do what the thread is for; the exception that has ended it, if it was one."""
        try:
            target()
        except (Stopped, OutOfTime, SystemExit):
            pass
        except BaseException as error:
            return error
        return None

    def report(self, error: BaseException) -> None:
        """What Python does with an exception that ends a thread."""
        told = (type(error), error, error.__traceback__, self.thread)
        threading.excepthook(threading.ExceptHookArgs(told))

    def __str__(self) -> str:
        """The thread and the line of its program at which it is."""
        return f"thread {self.thread.name!r}, at {place_of(self.thread.ident)}"


class Scheduler:
    """Which thread may run, and what has to happen before another may."""

    def __init__(self, segment: Segment[Node], patience: float, longest: float = LONGEST) -> None:
        self.segment = segment
        self.clock = segment.clock
        self.failure: Exception | None = None  # of a thread; the test is to hear of it
        self.on_failure: Callable[[Exception], None] = lambda failure: None
        """Called with the first one that is raised in a thread, by that thread."""
        self.wanted_locks: dict[int, object] = {}
        """What threads wait for without a time-out, by their identifiers."""
        self._patience = patience
        self._longest = longest
        self._last = self.clock.ticks + microseconds(longest)
        self._standstill = Standstill()
        self._owner = threading.get_ident()
        self._tasks: list[Task] = []  # in the order of their start, which is that of their turns
        self._running: Task | None = None
        self._returned = Turn()
        self._resumption_is_due = False
        self._ending = False

    def wait(self, ready: Ready, timeout: float | None) -> bool:
        """Let simulated time pass until `ready`, at most for `timeout` seconds; whether it is.

        Raises:
            SimulatedTimeError: the caller may not wait here, or would wait for ever.
        """
        task = self.current()
        if _in_event_loop():
            raise self.refusal("asyncio has a loop of its own, which waits in real time")
        if task is not None and self._ending:
            self._stop(task)
        if timeout is not None and timeout <= 0:
            self.count("looks whether something has come")
        if not ready() and (timeout is None or timeout > 0):
            longest = None if timeout is None else max(timeout, TICK)
            if task is None:
                self._pass_time(ready, longest)
            else:
                self._park(task, ready, longest)
        return bool(ready())

    def count(self, what: str) -> None:
        """The caller does something that takes no time, and may be doing so in a loop.

        Raises:
            SimulatedTimeError: it does so again and again, and never waits.
            Stopped: it has been told so, in a thread of the master.
            OutOfTime: the same in the thread that entered simulated time.
        """
        task = self.current()
        if self._standstill.goes_on(self.clock.ticks):
            return
        if task is not None and self.failure is not None:
            raise Stopped
        error = self.refusal(
            f"a loop {what} and never waits, at {place_of(threading.get_ident())}: simulated time"
            " passes only while the master waits, as in time.sleep()",
            HangError,
        )
        raise error if self._standstill.told_once() else OutOfTime(str(error))

    @property
    def knows_caller(self) -> bool:
        """Whether the thread that calls is in simulated time."""
        caller, running = threading.get_ident(), self._running
        return caller == self._owner or (running is not None and running.thread.ident == caller)

    @property
    def tasks(self) -> Sequence[Task]:
        """The threads of the master that are not over, in the order of their start."""
        return [task for task in self._tasks if not task.done]

    def everybody(self) -> str:
        """Where the thread that entered simulated time is, and every thread of the master."""
        return "; ".join([f"it is at {place_of(self._owner)}", *map(str, self.tasks)])

    def changed(self) -> None:
        """Something has happened: at this moment of the clock, all that wait look again."""
        self.current()
        if not self._resumption_is_due:
            self._resumption_is_due = True
            self.clock.after(0, self._resume_ready)

    def add(self, thread: threading.Thread) -> Task:
        """Take on a thread that is about to start."""
        self.changed()
        task = Task(thread)
        self._tasks.append(task)
        return task

    def current(self) -> Task | None:
        """The task whose thread calls; none for the thread that entered simulated time.

        Raises:
            SimulatedTimeError: the caller is neither.
        """
        caller, running = threading.get_ident(), self._running
        if running is not None and running.thread.ident == caller:
            return running
        if caller != self._owner:
            raise self.refusal(
                f"thread {threading.current_thread().name!r} runs in real time: name the module"
                " that starts it, as in simulated_time(bench, 'my_master')"
            )
        return None

    def refusal(
        self, message: str, kind: type[SimulatedTimeError] = SimulatedTimeError
    ) -> SimulatedTimeError:
        """An error to raise, which also reaches the test if it is raised in a thread."""
        error = kind(message)
        if threading.get_ident() != self._owner and self.failure is None:
            self.failure = error
            self.on_failure(error)
        return error

    def run_task(self, task: Task, target: Callable[[], None]) -> None:
        """What a thread of the master does from its start to its end."""
        task.turn.wait()
        error = None if self._ending else task.run(target)
        if error is not None and error is not self.failure:
            task.report(error)  # before the next one runs, so that reports have an order
        task.done = True
        if self._running is task:
            self.changed()
            self._returned.give()

    def end(self) -> None:
        """End every thread that still waits."""
        self._ending = True
        for task in self._tasks:
            try:
                self._resume(task)
            except SimulatedTimeError as error:  # one that is stuck keeps no other from ending
                self.failure = self.failure or error
            if task.done and task.thread.ident is not None:  # a limit may come before its start
                threading.Thread.join(task.thread, self._patience)  # in real time

    def _pass_time(self, ready: Ready, timeout: float | None) -> None:
        clock = self.clock
        end = clock.ticks + microseconds(LONGEST_WAIT if timeout is None else timeout)
        if clock.ticks > self._last:
            raise OutOfTime(f"{self._longest:g} s of simulated time: {self.everybody()}")
        while clock.next_tick <= end:
            self.segment.advance_to(clock.next_tick / MICROSECONDS)
            if self.failure is not None:
                raise self.failure
            if ready():
                return
        self.segment.advance_to(end / MICROSECONDS)
        if timeout is None:
            raise SimulatedTimeError(
                f"nothing has come in {LONGEST_WAIT:.0f} s of simulated time, and this wait has no"
                f" time-out: {self.everybody()}"
            )

    def _park(self, task: Task, ready: Ready, timeout: float | None) -> None:
        task.ready = ready
        timer = None if timeout is None else self.clock.after(timeout, partial(self._resume, task))
        self._returned.give()
        task.turn.wait()
        if timer is not None:
            timer.cancel()
        if self._ending:
            self._stop(task)

    def _resume_ready(self) -> None:
        self._resumption_is_due = False
        for task in self._tasks:
            if task.ready():
                self._resume(task)
        self._tasks = [task for task in self._tasks if not task.done]

    def _resume(self, task: Task) -> None:
        """Let a task run until it waits again, or is done."""
        if task.done:
            return
        if self.current() is not None:
            raise self.refusal("a thread of the master may not move the clock of the bench")
        self._running = task
        task.turn.give()
        back = self._returned.wait(timeout=self._patience)
        self._running = None
        if not back:
            told = f"{task} has not come back for {self._patience} s of real time"
            task.done = True  # as far as anybody here is concerned
            raise_in(task.thread.ident or 0, told)  # a loop in Python ends
            raise HangError(f"{told}: what it does there does not wait in simulated time")

    def _stop(self, task: Task) -> None:
        """End a task in its wait; one that goes on all the same is left there for good."""
        task.stop()
        self.failure = self.failure or SimulatedTimeError(
            f"{task} cannot be ended: an `except:` in it holds everything up"
        )
        self._returned.give()
        task.turn.wait()


def _in_event_loop() -> bool:
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


_in_force: list[Scheduler] = []


def enter(segment: Segment[Node], patience: float, longest: float = LONGEST) -> Scheduler:
    """Let simulated time be that of a segment.

    Raises:
        SimulatedTimeError: it is in force already.
    """
    if _in_force:
        raise SimulatedTimeError("simulated time is in force already: leave it before you enter it")
    _in_force.append(Scheduler(segment, patience, longest))
    return _in_force[0]


def leave() -> None:
    """Go back to real time."""
    _in_force.clear()


def in_force() -> Scheduler:
    """The scheduler of the simulated time that is in force.

    Raises:
        SimulatedTimeError: simulated time is not in force.
    """
    if not _in_force:
        raise SimulatedTimeError("simulated time is over: what was made in it waits no more")
    return _in_force[0]


def wait(ready: Ready, timeout: float | None = None) -> bool:
    """As `Scheduler.wait` of the one in force."""
    return in_force().wait(ready, timeout)


def changed() -> None:
    """As `Scheduler.changed`; nobody waits when simulated time is over."""
    if _in_force:
        _in_force[0].changed()
