"""`threading.Thread` and `Timer` in simulated time: real threads that wait for the baton."""

import threading
from functools import partial
from typing import Any

from simulators.simulated_time.in_force import baton, wait
from simulators.simulated_time.signals import Event
from simulators.simulated_time.task import Task


class Thread(threading.Thread):
    """As `threading.Thread`; it ends with simulated time, if not before."""

    _task: Task | None = None

    def start(self) -> None:
        """See `threading.Thread`."""
        if self._task is not None:
            raise RuntimeError("threads can only be started once")
        holder = baton()
        self.daemon = True  # one that cannot be ended does not keep the interpreter from ending
        self._task = holder.enlist(self)
        self.run = partial(holder.take_part, self._task, self.run)  # type: ignore[method-assign]
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
