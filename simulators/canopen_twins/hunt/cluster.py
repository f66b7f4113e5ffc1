"""Runs on the workers of a dask cluster; the files that they need travel along."""

from __future__ import annotations

import asyncio
import tempfile
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache, partial
from hashlib import sha256
from importlib import import_module
from itertools import count
from pathlib import Path
from threading import Lock
from typing import Any, TypeVar

from canopen_twins.errors import UserError
from canopen_twins.files.whole import read_plain
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.run import Result, run
from canopen_twins.hunt.workers import DEATHS, Death, Pool

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")

AHEAD = 2
"""Items on their way for each thread of the cluster: those of a worker that dies are suspect."""
LARGEST_FILE = 4 << 20  # bytes
CONNECTING = 10  # seconds


@dataclass(frozen=True)
class Bundle:
    """A contract and what lies beside it, as it travels."""

    name: str
    master: str
    files: tuple[tuple[str, bytes], ...]

    @classmethod
    def of(cls, contract: Contract, others: Iterable[Path]) -> Bundle:
        """Raises `UserError` if a file cannot be read, or two have one name."""
        paths = [contract.file, *others]
        if len({path.name for path in paths}) < len(paths):
            raise UserError("two of the files that travel have one name")
        files = tuple((path.name, read_plain(path, LARGEST_FILE)) for path in paths)
        return cls(contract.file.name, contract.master, files)


def play(bundle: Bundle, plan: Plan) -> Result:
    """One run of what has travelled here."""
    return run(_unpacked(bundle), plan)


def check(bundle: Bundle, _: object) -> None:
    """Raises `UserError` if the master cannot be run here."""
    scenario = _unpacked(bundle).scenario(Plan())
    if scenario.master is not None:
        scenario.master.check()


@cache
def _unpacked(bundle: Bundle) -> Contract:
    digest = sha256(repr(bundle).encode()).hexdigest()[:16]
    folder = Path(tempfile.mkdtemp(prefix=f"canopen-twins-{digest}-"))
    for name, content in bundle.files:
        (folder / name).write_bytes(content)
    return Contract(folder / bundle.name, bundle.master)


class Cluster(AbstractContextManager["Cluster"]):
    """A `Map` on a cluster; outcomes come in the order of the items.

    A run is in a process of its own on its worker: simulated time is that of a whole process. Whose
    worker dies is done again elsewhere, at most twice.
    """

    def __init__(self, address: str, lost: Callable[[Any, Death], Any]) -> None:
        """Raises `UserError` if nobody answers there, or distributed is missing."""
        try:
            distributed = import_module("distributed")  # an extra, and a second
        except ModuleNotFoundError as missing:
            hint = "pip install 'canopen-twins[dask]'"
            raise UserError(f"--dask needs {missing.name}: {hint}") from missing
        try:
            self._client = distributed.Client(address, timeout=CONNECTING, set_as_default=False)
        except (OSError, ValueError) as failure:
            raise UserError(f"no dask scheduler at {address}: {failure}") from failure
        self._address = address
        self._died: type[Exception] = distributed.KilledWorker
        self._lost = lost
        self._numbers = count()

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def __call__(
        self, function: Callable[[Item], Outcome], items: Iterable[Item]
    ) -> Iterator[Outcome]:
        """Raises what the function raises, and `UserError` when the scheduler is gone."""
        try:
            yield from self._outcomes(function, items)
        except (OSError, CancelledError, asyncio.CancelledError) as failure:
            told = f"the dask scheduler at {self._address} is gone: {failure}"
            raise UserError(told) from failure

    def _outcomes(
        self, function: Callable[[Item], Outcome], items: Iterable[Item]
    ) -> Iterator[Outcome]:
        upcoming = iter(items)
        pending: deque[tuple[Item, Any]] = deque()
        while True:
            while len(pending) < self._room and (fresh := next(upcoming, upcoming)) is not upcoming:
                item: Any = fresh
                pending.append((item, self._submit(function, item)))
            if not pending:
                return
            item, future = pending.popleft()
            yield self._outcome(function, item, future)

    @property
    def _room(self) -> int:
        threads: int = sum(self._client.nthreads().values())
        return AHEAD * max(threads, 1)

    def _submit(self, function: Callable[[Item], Outcome], item: Item) -> Any:
        key = f"canopen-twins-{next(self._numbers)}"
        task = partial(_in_a_process, function, self._lost)
        return self._client.submit(task, item, key=key, pure=False)

    def _outcome(self, function: Callable[[Item], Outcome], item: Item, future: Any) -> Outcome:
        for _ in range(DEATHS):
            try:
                outcome: Outcome = future.result()
                return outcome
            except self._died:
                future = self._submit(function, item)
        lost: Outcome = self._lost(item, Death("its worker has died"))
        return lost


ONE_AT_A_TIME = Lock()
"""A worker with several threads has one process for all of them."""


@cache
def _pool(lost: Callable[[Any, Death], Any]) -> Pool:
    """That of a worker: one process that waits for the next run."""
    return Pool(1, lost)


def _in_a_process(
    function: Callable[[Item], Outcome], lost: Callable[[Any, Death], Any], item: Item
) -> Outcome:
    with ONE_AT_A_TIME:
        (outcome,) = _pool(lost)(function, [item])
    return outcome
