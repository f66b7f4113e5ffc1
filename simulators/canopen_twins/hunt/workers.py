"""Runs in other processes: each has pipes of its own, and one that dies loses its run only."""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import logging
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import count
from selectors import EVENT_READ, DefaultSelector
from typing import IO, Any, Generic, NamedTuple, Protocol, TypeVar

from canopen_twins.errors import UserError

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")

AHEAD = 12
"""Items asked for before the first of them is done, for each process: the longest run of a hunt
takes as long as twenty others, and with 3 two processes were 1.5 times as fast as one."""
DEATHS = 3
"""Of processes with one item, after which it is to blame, and what ends like it at once."""
RESUMES = "resumes"
"""An attribute of items that do not do again what has ended them."""
MOST_JOBS = 1024
PATIENCE = 300.0  # seconds of real time for one item
HANG = 45.0
"""Seconds of real time for one run in a worker: beyond what ends a loop in Python, so that it hangs
in C."""
ENDING = 5.0  # seconds of real time from the end of a pipe to that of its process
SIZE = 8  # bytes before each message


class Death(NamedTuple):
    """How an item has ended the processes that were given it."""

    words: str
    """As SIGSEGV, or exit code 3."""
    place: str = ""
    """The line of Python at which it was, as `my_master.py:23`; empty if nobody knows."""
    hangs: bool = False
    """Whether it has looked at its watch itself: then there is no doubt."""


class Map(Protocol):
    """Calls a function with one item after the other, here or in other processes, in any order."""

    def __call__(
        self, function: Callable[[Item], Outcome], items: Iterable[Item]
    ) -> Iterator[Outcome]:
        """What comes of it, in their order; items are asked for as they are wanted."""


class Worker:
    """A process that is given one item after the other; it ends with its pipe."""

    def __init__(self) -> None:
        path = os.pathsep.join(filter(None, sys.path))
        self._crash = tempfile.TemporaryFile()  # noqa: SIM115 - as long as the process
        told = self._crash.fileno()
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(told), str(HANG)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": path},
            pass_fds=[told],
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._there: IO[bytes] = self._process.stdin
        self.here: IO[bytes] = self._process.stdout

    def give(self, function: Callable[[Any], Any], item: object) -> None:
        """Have something done; nothing happens if it has died, which `take` tells."""
        with contextlib.suppress(OSError):
            _send(self._there, (function, item))

    def take(self) -> Any:
        """What has come of it.

        Raises:
            EOFError: it has died.
            UserError: as the function does.
            RuntimeError: anything else that the function has raised.
        """
        outcome, refusal, bug = _receive(self.here)
        if refusal:
            raise UserError(refusal)
        if bug:
            raise RuntimeError(f"in another process:\n{bug}")
        return outcome

    def death(self) -> Death:
        """How it has died; it is waited for."""
        # it brings canopen: for those that die
        from canopen_twins.bench.limits import place_of_crash  # noqa: PLC0415

        try:
            status = self._process.wait(ENDING)
        except subprocess.TimeoutExpired:
            return Death("no answer")
        self._crash.seek(0)
        told = self._crash.read().decode("utf-8", "replace")
        hangs = told.startswith("Timeout")
        return Death(_late(HANG) if hangs else _ended(status), place_of_crash(told), hangs)

    def end(self) -> None:
        """At once."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(OSError):
            self._there.close()
        self.here.close()
        self._crash.close()


def _late(seconds: float) -> str:
    return f"no end in {seconds:g} s of real time"


def _ended(status: int) -> str:
    """How a process has ended, by what `subprocess` says of it."""
    if status >= 0:
        return f"exit code {status}"
    known = {each.value: each.name for each in signal.Signals}
    return known.get(-status, f"signal {-status}")


@dataclass
class Job(Generic[Item]):
    """An item on its way, and where its outcome belongs."""

    number: int
    item: Item
    function: Callable[[Any], Any]
    waiting: deque[Job[Any]]
    done: dict[int, Any]
    deaths: int = 0
    since: float = 0.0


class Pool(contextlib.AbstractContextManager["Pool"]):
    """A `Map` of several processes; outcomes come in the order of the items, whoever was faster.

    How many items are asked for ahead depends on nothing but the number of processes, so that a
    search with as many of them is the same again; one process is given one after the other. Whoever
    takes an outcome may have others done before he takes the next.
    """

    def __init__(
        self, jobs: int, lost: Callable[[Any, Death], Any], patience: float = PATIENCE
    ) -> None:
        """`lost` gives the outcome of an item that ends every process, or takes for ever."""
        self._jobs = jobs
        self._ahead = AHEAD * jobs if jobs > 1 else 1
        self._lost = lost
        self._patience = patience
        self._idle: list[Worker] = []
        self._busy: dict[Worker, Job[Any]] = {}
        self._confirmed: set[Death] = set()
        self._selector = DefaultSelector()

    def __exit__(self, *_: object) -> None:
        for worker in [*self._idle, *self._busy]:
            worker.end()
        self._selector.close()

    def __call__(
        self, function: Callable[[Item], Outcome], items: Iterable[Item]
    ) -> Iterator[Outcome]:
        """Raises what the function raises, but for the death of a process."""
        upcoming = enumerate(items)
        waiting: deque[Job[Any]] = deque()
        done: dict[int, Outcome] = {}
        asked = due = 0
        while True:
            while asked < due + self._ahead and (each := next(upcoming, None)):
                waiting.append(Job(*each, function, waiting, done))
                asked += 1
            self._hand_out(waiting)
            if due in done:
                yield done.pop(due)
                due += 1
            elif due < asked:
                self._collect()
            else:
                return

    def _hand_out(self, waiting: deque[Job[Any]]) -> None:
        while waiting and len(self._busy) < self._jobs:
            worker = self._idle.pop() if self._idle else self._hired()
            job = self._busy[worker] = waiting.popleft()
            job.since = time.monotonic()
            worker.give(job.function, job.item)

    def _hired(self) -> Worker:
        worker = Worker()
        self._selector.register(worker.here, EVENT_READ, worker)
        return worker

    def _collect(self) -> None:
        """Wait for the next one that is done, dies, or has had its time, whosever it is."""
        oldest = min(job.since for job in self._busy.values())
        ready = self._selector.select(max(0.0, oldest + self._patience - time.monotonic()))
        workers = [key.data for key, _ in ready if key.data in self._busy]
        if not ready:
            late = time.monotonic() - self._patience
            workers = [worker for worker, job in self._busy.items() if job.since <= late]
        for worker in workers:
            job = self._busy.pop(worker)
            try:
                job.done[job.number] = worker.take() if ready else _never()
                self._idle.append(worker)
            except EOFError:
                self._bury(worker, job, is_late=not ready)
            except BaseException:
                self._idle.append(worker)
                raise

    def _bury(self, worker: Worker, job: Job[Any], is_late: bool) -> None:
        death = Death(_late(self._patience)) if is_late else worker.death()
        self._selector.unregister(worker.here)
        worker.end()
        job.deaths += 1
        is_known = death.hangs or death in self._confirmed
        if job.deaths < DEATHS and (getattr(job.item, RESUMES, False) or not is_known):
            job.waiting.appendleft(job)
        else:
            self._confirmed.add(death)
            job.done[job.number] = self._lost(job.item, death)


def _never() -> Any:
    raise EOFError


def in_turn(function: Callable[[Item], Outcome], items: Iterable[Item]) -> Iterator[Outcome]:
    """A `Map` in this process."""
    return map(function, items)


@contextlib.contextmanager
def workers(jobs: int, lost: Callable[[Any, Death], Any]) -> Iterator[Map]:
    """So many processes, even if it is one: a master that ends its own does not end ours.

    Raises:
        UserError: so many there cannot be.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise UserError(f"--jobs {jobs} is not in 1..{MOST_JOBS}")
    if jobs == 1 and sys.platform == "win32":  # which does not wait for several pipes at once
        yield in_turn
    else:
        with Pool(jobs, lost) as pool:
            yield pool


def _send(pipe: IO[bytes], message: object) -> None:
    data = pickle.dumps(message)
    pipe.write(len(data).to_bytes(SIZE, "big") + data)
    pipe.flush()


def _receive(pipe: IO[bytes]) -> Any:
    """Raises `EOFError` at the end, in the middle of a message too."""
    size = int.from_bytes(_read(pipe, SIZE), "big")
    return pickle.loads(_read(pipe, size))


def _read(pipe: IO[bytes], size: int) -> bytes:
    data = pipe.read(size)
    if len(data) < size:
        raise EOFError
    return data


def work(here: IO[bytes], there: IO[bytes]) -> None:
    """Do what comes until the pipe ends; what masters print and log is for nobody."""
    logging.disable(logging.CRITICAL)
    for number in count():
        if (
            number == 1
        ):  # what the first has imported stays: nobody need look through it for garbage
            gc.collect()
            gc.freeze()
        try:
            function, item = _receive(here)
        except EOFError:
            return
        outcome, refusal, bug = None, "", ""
        try:
            outcome = function(item)
        except UserError as error:
            refusal = str(error)
        except Exception:
            bug = traceback.format_exc()
        _send(there, (outcome, refusal, bug))


_limits: list[tuple[int, float]] = []
"""In a worker: the descriptor of the file that tells where it was at its end, and how many seconds
of real time it may take."""


@contextlib.contextmanager
def watched() -> Iterator[None]:
    """A worker that hangs in here in C, where nothing in Python could end it, ends."""
    if not _limits:
        yield
        return
    file, seconds = _limits[0]
    faulthandler.dump_traceback_later(seconds, exit=True, file=file)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def _main() -> None:
    """The process: its own output is the pipe, so nobody else may write there."""
    there = os.fdopen(os.dup(1), "wb")
    here = os.fdopen(os.dup(0), "rb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1):
        os.dup2(nowhere, number)
    faulthandler.enable(int(sys.argv[1]))
    _limits.append((int(sys.argv[1]), float(sys.argv[2])))
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):
        work(here, there)


if __name__ == "__main__":
    # what comes has the classes of the module by its name, not those of `__main__`
    sys.modules[__spec__.name] = sys.modules[__name__]
    _main()
