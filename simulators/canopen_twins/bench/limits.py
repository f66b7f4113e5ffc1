"""Limits of what runs in simulated time, and where a program was when it went beyond one."""

import os
import re
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType, TracebackType
from typing import Self

import can
import canopen

MOST_AT_ONCE = 100_000  # things done at one moment of the clock: a loop that lets no time pass
BUSY = 2  # times as long as it may take is how long it may last where others have the cores
AGAIN = 1.0  # seconds after which one that has held up the end is told once more

_PACKAGES = tuple(str(Path(file).parent) for file in (can.__file__, canopen.__file__))
_OURS = str(Path(__file__).parents[1])
_STANDARD = str(Path(os.__file__).parent)
_INSTALLED = ("site-packages", "dist-packages")  # inside of the standard library, in some places


class SimulatedTimeError(RuntimeError):
    """Something that cannot work in simulated time; the message says what, and what can."""


class HangError(SimulatedTimeError):
    """The program itself hangs: a loop that never waits, or threads that wait for each other."""


class OutOfTime(BaseException):
    """A limit of simulated or of real time has been reached."""


class NoCore(OutOfTime):
    """It is one of real time, in most of which the process had no core: nobody here is to blame."""


def place(frame: FrameType | None) -> str:
    """Where a program is: the innermost line that is no library's, as `file.py:12 in function`."""
    found, innermost = frame, frame
    while found is not None and _is_library(found.f_code.co_filename):
        found = found.f_back
    if (shown := found or innermost) is None:
        return "its end"
    return f"{shown.f_code.co_filename}:{shown.f_lineno} in {shown.f_code.co_name}"


def place_of(thread_id: int | None) -> str:
    """The same of a thread, by its identifier."""
    return place(sys._current_frames().get(thread_id or 0))  # noqa: SLF001 - there is no other way


def place_of_crash(told: str) -> str:
    """The same of what `faulthandler` has written, as `file.py:12`; empty if it is nowhere.

    That is of the thread that has crashed, or of the first one that is in the program.
    """
    if "Current thread" in told:
        told = told.partition("Current thread")[2].partition("\n\n")[0]
    for file, line in re.findall(r'^  File "(.*)", line (\d+) in ', told, re.MULTILINE):
        if not _is_library(file):
            return f"{Path(file).name}:{line}"
    return ""


def _is_library(file: str) -> bool:
    standard = file.startswith(_STANDARD) and not any(part in file for part in _INSTALLED)
    return standard or file.startswith((_OURS, *_PACKAGES, "<frozen"))


class Standstill:
    """Counts what is done at one moment of a clock: whoever lets no time pass would hang."""

    def __init__(self, most: int = MOST_AT_ONCE) -> None:
        self._most = most
        self._tick = -1
        self._count = 0

    def goes_on(self, tick: int) -> bool:
        """One more is done at a microsecond; whether that is still within the limit."""
        self._count = self._count + 1 if tick == self._tick else 1
        self._tick = tick
        return self._count <= self._most

    def told_once(self) -> bool:
        """Whether this is the first time beyond the limit at this moment."""
        return self._count == self._most + 1


class RealTimeLimit:
    """Ends what the thread that enters it does for too long, in whatever loop that is.

    It comes as `OutOfTime` at the next line of Python, so nothing that waits in C is ended. Time in
    which others have the cores of a busy machine does not count, but after `BUSY` times as long it
    is over all the same, which comes as `NoCore`.

    Args:
        seconds: In which the process has a core, from the beginning of the block to its end.
        told: Where everybody is, in words.
    """

    def __init__(self, seconds: float, told: Callable[[], str]) -> None:
        self._seconds = seconds
        self._told = told
        self._thread_id = threading.get_ident()
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="limit of time", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        with self._lock:
            self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        began, used = time.monotonic(), time.process_time()
        wait = self._seconds
        while not self._over.wait(wait):
            had = time.process_time() - used
            last = began + BUSY * self._seconds - time.monotonic()
            wait = min(self._seconds - had, last)
            if wait <= 0:
                self._end(had, NoCore if had < self._seconds else OutOfTime)
                wait = AGAIN

    def _end(self, had: float, kind: type[OutOfTime]) -> None:
        told = f"{self._seconds:g} s of real time"
        if kind is NoCore:
            whole = BUSY * self._seconds
            told = f"{whole:g} s of real time, of which the process had a core for {had:.2f} s"
        with self._lock:
            if not self._over.is_set():
                raise_in(self._thread_id, f"{told}: {self._told()}", kind)


def raise_in(thread_id: int, message: str, kind: type[OutOfTime] = OutOfTime) -> None:
    """Have a thread raise `OutOfTime` at its next line of Python."""
    import ctypes  # noqa: PLC0415 - hardly a run goes beyond a limit

    class Limit(kind):  # type: ignore[valid-type, misc]
        def __init__(self) -> None:
            super().__init__(message)

    Limit.__name__ = Limit.__qualname__ = kind.__name__
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread_id), ctypes.py_object(Limit))
