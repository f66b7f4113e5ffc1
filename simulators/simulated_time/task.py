"""A thread of the master as simulated time sees it, and the two ways in which it ends early."""

import sys
import threading
import traceback
from collections.abc import Callable

Ready = Callable[[], object]
"""Whether what somebody waits for has come; asked by whoever holds the baton."""

MOST_STOPS = 100  # attempts to go on of a thread that has been told to end


class SimulatedTimeError(RuntimeError):
    """Something that cannot work in simulated time; the message says what, and what can."""


class Stopped(BaseException):
    """Ends a thread of the master with simulated time; no `except Exception` holds it up."""


class Task:
    """What a thread waits for, and the semaphore that says when it is its turn."""

    def __init__(self, thread: threading.Thread) -> None:
        self.thread = thread
        self.turn = threading.Semaphore(0)
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
        except (Stopped, SystemExit):
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
        frames = sys._current_frames()  # noqa: SLF001 - the only way to see another thread's
        stack = traceback.extract_stack(frames.get(self.thread.ident or 0))
        where = f", at {stack[-1].filename}:{stack[-1].lineno}" if stack else ""
        return f"thread {self.thread.name!r}{where}"
