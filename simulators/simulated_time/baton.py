"""One thread at a time: who has to wait passes the baton on, and simulated time passes instead.

The thread that entered simulated time moves the clock, whenever it waits. The threads of the master
are real ones, but each of them runs only while it holds the baton, from one of its waits to the
next, inside an action of the clock. Which of them runs when is therefore a property of the program,
never of the scheduler of the operating system.
"""

import asyncio
import threading
from collections.abc import Callable
from functools import partial

from simulators.clock import MICROSECONDS, microseconds
from simulators.node import Node
from simulators.segment import Segment
from simulators.simulated_time.task import Ready, SimulatedTimeError, Task

TICK = 1 / MICROSECONDS  # seconds; who waits for less, as for a rest left by rounding, gets this
LONGEST_WAIT = 3600.0  # simulated seconds the test waits for what has no time-out of its own


class Baton:
    """Who may run, and what has to happen before somebody else may."""

    def __init__(self, segment: Segment[Node], patience: float) -> None:
        self.segment = segment
        self.clock = segment.clock
        self.failure: Exception | None = None  # of a thread; the test is to hear of it
        self._patience = patience
        self._owner = threading.get_ident()
        self._tasks: list[Task] = []  # in the order of their start, which is that of their turns
        self._running: Task | None = None
        self._returned = threading.Semaphore(0)
        self._look_is_due = False
        self._ending = False

    def wait(self, ready: Ready, timeout: float | None) -> bool:
        """Let simulated time pass until `ready`, at most for `timeout` seconds; whether it is.

        Raises:
            SimulatedTimeError: the caller may not wait here, or would wait for ever.
        """
        task = self.holder()
        if _in_event_loop():
            raise self.refusal("asyncio has a loop of its own, which waits in real time")
        if task is not None and self._ending:
            self._stop(task)
        if not ready() and (timeout is None or timeout > 0):
            longest = None if timeout is None else max(timeout, TICK)
            if task is None:
                self._pass_time(ready, longest)
            else:
                self._park(task, ready, longest)
        return bool(ready())

    def changed(self) -> None:
        """Something has happened: at this moment of the clock, all that wait look again."""
        self.holder()
        if not self._look_is_due:
            self._look_is_due = True
            self.clock.after(0, self._look)

    def enlist(self, thread: threading.Thread) -> Task:
        """Let a thread that is about to start take part."""
        self.changed()
        task = Task(thread)
        self._tasks.append(task)
        return task

    def holder(self) -> Task | None:
        """The task that runs; none for the thread that entered simulated time.

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

    def refusal(self, message: str) -> SimulatedTimeError:
        """An error to raise, which also reaches the test if it is raised in a thread."""
        error = SimulatedTimeError(message)
        if threading.get_ident() != self._owner:
            self.failure = self.failure or error
        return error

    def take_part(self, task: Task, target: Callable[[], None]) -> None:
        """What a thread of the master does: run when it is its turn."""
        task.turn.acquire()
        error = None if self._ending else task.run(target)
        if error is not None and error is not self.failure:
            task.report(error)  # before the next one runs, so that reports have an order
        task.done = True
        if self._running is task:
            self.changed()
            self._returned.release()

    def end(self) -> None:
        """End every thread that still waits."""
        self._ending = True
        for task in self._tasks:
            try:
                self._resume(task)
            except SimulatedTimeError as error:  # one that is stuck keeps no other from ending
                self.failure = self.failure or error
            if task.done:
                threading.Thread.join(task.thread, self._patience)  # in real time

    def _pass_time(self, ready: Ready, timeout: float | None) -> None:
        clock = self.clock
        end = clock.ticks + microseconds(LONGEST_WAIT if timeout is None else timeout)
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
                " time-out"
            )

    def _park(self, task: Task, ready: Ready, timeout: float | None) -> None:
        task.ready = ready
        timer = None if timeout is None else self.clock.after(timeout, partial(self._resume, task))
        self._returned.release()
        task.turn.acquire()
        if timer is not None:
            timer.cancel()
        if self._ending:
            self._stop(task)

    def _look(self) -> None:
        self._look_is_due = False
        for task in self._tasks:
            if task.ready():
                self._resume(task)
        self._tasks = [task for task in self._tasks if not task.done]

    def _resume(self, task: Task) -> None:
        """Let a task run until it waits again, or is done."""
        if task.done:
            return
        if self.holder() is not None:
            raise self.refusal("a thread of the master may not move the clock of the bench")
        self._running = task
        task.turn.release()
        back = self._returned.acquire(timeout=self._patience)
        self._running = None
        if not back:
            task.done = True  # as far as anybody here is concerned
            raise SimulatedTimeError(
                f"{task} has not come back for {self._patience} s of real time: what it does there"
                " does not wait in simulated time"
            )

    def _stop(self, task: Task) -> None:
        """End a task in its wait; one that goes on all the same is left there for good."""
        task.stop()
        self.failure = self.failure or SimulatedTimeError(
            f"{task} cannot be ended: an `except:` in it holds everything up"
        )
        self._returned.release()
        task.turn.acquire()


def _in_event_loop() -> bool:
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True
