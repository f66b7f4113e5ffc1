"""Runs in other processes: each has pipes of its own, and one that dies loses its run only."""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import subprocess
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from selectors import EVENT_READ, DefaultSelector
from typing import IO, Any, Generic, TypeVar

from canopen_twins.errors import UserError

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")

AHEAD = 3
"""Items asked for before the first of them is done, for each process."""
DEATHS = 3
"""Of processes with one item, after which it is to blame."""
MOST_JOBS = 1024
PATIENCE = 300.0  # seconds of real time for one item
SIZE = 8  # bytes before each message


class Worker:
    """A process that is given one item after the other; it ends with its pipe."""

    def __init__(self) -> None:
        path = os.pathsep.join(filter(None, sys.path))
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": path},
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

    def end(self) -> None:
        """At once."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(OSError):
            self._there.close()
        self.here.close()


@dataclass
class Job(Generic[Item]):
    """An item on its way."""

    number: int
    item: Item
    deaths: int = 0
    since: float = 0.0


class Pool(contextlib.AbstractContextManager["Pool"]):
    """A `Map` of several processes; outcomes come in the order of the items, whoever was faster.

    How many items are asked for ahead depends on nothing but the number of processes, so that a
    search with as many of them is the same again.
    """

    def __init__(self, jobs: int, lost: Callable[[Any], Any], patience: float = PATIENCE) -> None:
        """`lost` gives the outcome of an item that ends every process, or takes for ever."""
        self._jobs = jobs
        self._lost = lost
        self._patience = patience
        self._idle: list[Worker] = []
        self._busy: dict[Worker, Job[Any]] = {}
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
        waiting: deque[Job[Item]] = deque()
        done: dict[int, Outcome] = {}
        asked = due = 0
        while True:
            while asked < due + AHEAD * self._jobs and (each := next(upcoming, None)):
                waiting.append(Job(*each))
                asked += 1
            self._hand_out(function, waiting)
            if due in done:
                yield done.pop(due)
                due += 1
            elif self._busy:
                self._collect(waiting, done)
            else:
                return

    def _hand_out(self, function: Callable[[Item], Outcome], waiting: deque[Job[Item]]) -> None:
        while waiting and len(self._busy) < self._jobs:
            worker = self._idle.pop() if self._idle else self._hired()
            job = self._busy[worker] = waiting.popleft()
            job.since = time.monotonic()
            worker.give(function, job.item)

    def _hired(self) -> Worker:
        worker = Worker()
        self._selector.register(worker.here, EVENT_READ, worker)
        return worker

    def _collect(self, waiting: deque[Job[Item]], done: dict[int, Outcome]) -> None:
        """Wait for the next one that is done, dies, or has had its time."""
        oldest = min(job.since for job in self._busy.values())
        ready = self._selector.select(max(0.0, oldest + self._patience - time.monotonic()))
        workers = [key.data for key, _ in ready if key.data in self._busy]
        if not ready:
            late = time.monotonic() - self._patience
            workers = [worker for worker, job in self._busy.items() if job.since <= late]
        for worker in workers:
            job = self._busy.pop(worker)
            try:
                done[job.number] = worker.take() if ready else _never()
                self._idle.append(worker)
            except EOFError:
                self._dismiss(worker)
                job.deaths += 1
                if job.deaths < DEATHS:
                    waiting.appendleft(job)
                else:
                    done[job.number] = self._lost(job.item)
            except BaseException:
                self._idle.append(worker)
                raise

    def _dismiss(self, worker: Worker) -> None:
        self._selector.unregister(worker.here)
        worker.end()


def _never() -> Any:
    raise EOFError


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
    while True:
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


def _main() -> None:
    """The process: its own output is the pipe, so nobody else may write there."""
    there = os.fdopen(os.dup(1), "wb")
    here = os.fdopen(os.dup(0), "rb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1):
        os.dup2(nowhere, number)
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):
        work(here, there)


if __name__ == "__main__":
    # what comes has the classes of the module by its name, not those of `__main__`
    sys.modules[__spec__.name] = sys.modules[__name__]
    _main()
