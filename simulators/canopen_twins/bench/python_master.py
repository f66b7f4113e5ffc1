"""A master in Python that is run as it is: its function in a thread, in simulated time.

Its modules are imported afresh for every run, so that no run finds what the one before has left in
them; everything else that it imports stays.
"""

from __future__ import annotations

import importlib
import inspect
import os
import random
import sys
import sysconfig
import threading
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any, NamedTuple, NoReturn

import canopen

from canopen_twins.bench.children import ended_children
from canopen_twins.bench.limits import (
    HangError,
    NoCore,
    OutOfTime,
    RealTimeLimit,
    SimulatedTimeError,
    place_of,
)
from canopen_twins.bench.simulated_time import WALL, in_simulated_time
from canopen_twins.bench.simulated_time.primitives import Thread
from canopen_twins.bench.simulated_time.scheduler import Scheduler, Stopped
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown

BIT_RATE = 500_000
BUS: Mapping[str, object] = {"interface": "socketcan", "channel": "can0"}
"""What a master is told to connect to; in simulated time any bus is that of the bench."""
NETWORK = "network"
OURS = "canopen_twins"
INSTALLED = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib")})


class Ended(NamedTuple):
    """How a master has ended otherwise than by returning."""

    words: str
    """What happened, and where in its files."""
    place: str
    """The innermost line of its files, as `my_master.py:23`; empty if it has none in it."""
    its_own: bool
    """Whether it is to blame; else simulated time could not be kept up."""


@dataclass(frozen=True)
class PythonMaster:
    """A function, as `my_master:main`, looked for from `folders` and then as any import."""

    name: str
    folders: tuple[Path, ...] = ()
    wall: float = WALL
    """Seconds of real time that a run of it may take, as `RealTimeLimit` counts them."""

    @classmethod
    def beside(cls, name: str, file: Path) -> PythonMaster:
        """One of a file: looked for from the working directory, beside the file, and above it.

        Raises:
            UserError: the name is none.
        """
        module, colon, function = name.partition(":")
        words = [*module.split("."), *function.split(".")]
        if not colon or not all(map(str.isidentifier, words)):
            raise UserError(f"master {name!r}: write it as MODULE:FUNCTION, such as my_master:main")
        folder, here = file.resolve().parent, _here()
        return cls(name, (*([here] if here else []), folder, folder.parent))

    def check(self) -> None:
        """See whether it can be run.

        Raises:
            UserError: there is no such module or function, the module cannot be imported, or the
                function wants what no master is given.
        """
        with self._imported() as (function, _):
            _arguments(self.name, function, BIT_RATE)

    @contextmanager
    def running(
        self,
        segment: Segment[Node],
        ended: Callable[[Ended], None],
        seed: int = 1,
        left: Callable[[str], None] = lambda processes: None,
    ) -> Iterator[Callable[[], str]]:
        """Run it while simulated time passes inside; its threads end with the block.

        It gives what tells in which lines of its files its threads are.

        Args:
            segment: Where its bus is.
            ended: Called on the clock of the segment when it has ended otherwise than by returning,
                or one of its threads has.
            seed: Of the chance that it finds in `random` and the like.
            left: Called with the commands of processes that it has left behind; they have ended.

        Raises:
            UserError: as `check` does.
        """
        with ended_children(left), self._imported() as (function, modules):
            files = {module.__file__ or "" for module in modules}
            call = _arguments(self.name, function, segment.bit_rate or BIT_RATE)
            with _seeded(seed), _no_exit(), in_simulated_time(segment, modules) as scheduler:
                reports = _Reports(scheduler, files, ended)
                scheduler.on_failure = reports.later
                with reports.of_threads():
                    Thread(target=reports.of(call), name="master").start()
                    try:
                        with RealTimeLimit(self.wall, scheduler.everybody):
                            yield partial(_whereabouts, scheduler, files)
                    except SimulatedTimeError as failure:
                        reports.take(failure)
                    except NoCore as busy:
                        reports.take(SimulatedTimeError(str(busy)))
                    except OutOfTime as limit:
                        reports.take(HangError(str(limit)))
            if scheduler.failure is not None:
                reports.take(scheduler.failure)

    @contextmanager
    def _imported(self) -> Iterator[tuple[Callable[..., object], Sequence[ModuleType]]]:
        """Its function, and the modules of its project as they have just been imported."""
        name, _, function = self.name.partition(":")
        folders = [str(folder) for folder in self.folders]
        package = name.partition(".")[0]
        before = _of_project(folders, package, list(sys.modules))
        path = list(sys.path)
        for module in before:
            del sys.modules[module]
        known = set(sys.modules)
        sys.path[:0] = folders
        here = _here()
        try:
            importlib.invalidate_caches()
            found = _attribute(self.name, _import(self.name, name), function)
            yield found, list(_of_project(folders, package, _new(known)).values())
        finally:
            sys.path[:] = path
            for module in _of_project(folders, package, _new(known)):
                del sys.modules[module]
            sys.modules.update(before)
            if here is not None:
                with suppress(FileNotFoundError):  # the master has deleted it
                    os.chdir(here)


def _here() -> Path | None:
    """The working directory; None if somebody has deleted it."""
    with suppress(FileNotFoundError):
        return Path.cwd()
    return None


def _of_project(
    folders: Sequence[str], package: str, names: Iterable[str]
) -> dict[str, ModuleType]:
    """Those modules that are the user's own: of his package, or below his folders."""
    below = tuple(os.path.join(folder, "") for folder in folders)  # noqa: PTH118 - of a prefix
    return {
        name: module
        for name in names
        if (module := sys.modules.get(name)) is not None
        if name not in ("__main__", OURS) and not name.startswith(f"{OURS}.")
        if name == package or name.startswith(f"{package}.") or _is_below(module, below)
    }


def _new(known: Collection[str]) -> list[str]:
    return [name for name in sys.modules if name not in known]


def _is_below(module: ModuleType, folders: tuple[str, ...]) -> bool:
    file = getattr(module, "__file__", None)
    return (
        isinstance(file, str)
        and file.startswith(folders)
        and not file.startswith(INSTALLED)
        and "site-packages" not in file
    )


def _import(master: str, name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as missing:
        if name == missing.name or name.startswith(f"{missing.name}."):
            raise UserError(
                f"master {master!r}: there is no module {missing.name!r} here or beside the file"
            ) from None
        raise UserError(f"master {master!r} cannot be imported: {missing}") from missing
    except Exception as error:  # whatever a module of the user's raises
        raise UserError(
            f"master {master!r} cannot be imported: {type(error).__name__}: {error}"
        ) from error


def _attribute(master: str, module: ModuleType, name: str) -> Callable[..., object]:
    found: Any = module
    for word in name.split("."):
        if not hasattr(found, word):
            known = [each for each, value in vars(found).items() if callable(value)]
            raise UserError(f"master {master!r}: {unknown('function', word, known)}")
        found = getattr(found, word)
    if not callable(found):
        raise UserError(f"master {master!r}: {name} is no function")
    if inspect.iscoroutinefunction(found):
        raise UserError(f"master {master!r}: {name} is of asyncio, which has a loop of its own")
    if inspect.isgeneratorfunction(found):
        raise UserError(f"master {master!r}: {name} has a yield in it: a call of it does nothing")
    return found  # type: ignore[no-any-return]


def _arguments(master: str, function: Callable[..., object], bit_rate: int) -> Callable[[], object]:
    """A call of it with what it asks for: a connected network, or what python-can connects with.

    Raises:
        UserError: it wants something else.
    """
    bus = {**BUS, "bitrate": bit_rate}
    given: dict[str, object] = {}
    network, names = "", []
    for each in inspect.signature(function).parameters.values():
        if each.kind is each.VAR_KEYWORD:
            given |= bus
        elif each.name == NETWORK or each.annotation in (canopen.Network, "canopen.Network"):
            network = each.name
        elif each.name in bus:
            given[each.name] = bus[each.name]
        elif each.default is each.empty and each.kind is not each.VAR_POSITIONAL:
            names.append(each.name)
    if names:
        raise UserError(
            f"master {master!r} wants {', '.join(names)}: it is called with a canopen.Network, or"
            f" with {', '.join(bus)}, as far as it takes them"
        )
    return partial(_call, function, given, bus, network)


def _call(
    function: Callable[..., object],
    given: Mapping[str, object],
    bus: Mapping[str, object],
    network: str,
) -> object:
    if not network:
        return function(**given)
    connected = canopen.Network()
    connected.connect(**bus)  # until the run is over: its threads may go on when it returns
    return function(**{**given, network: connected})


def _whereabouts(scheduler: Scheduler, files: set[str]) -> str:
    """In the order of their start; those of python-can are in none of its files."""
    places = (place_of(task.thread.ident).partition(":") for task in scheduler.tasks)
    return ", ".join(f"{Path(file).name}:{rest}" for file, _, rest in places if file in files)


class _Reports:
    """Tells of exceptions in threads of the master, on the clock: nobody is in the middle then."""

    def __init__(
        self, scheduler: Scheduler, files: set[str], ended: Callable[[Ended], None]
    ) -> None:
        self._scheduler = scheduler
        self._files = files
        self._ended = ended
        self._told = False

    def of(self, call: Callable[[], object]) -> Callable[[], None]:
        """What the thread of the master does."""

        def target() -> None:
            try:
                call()
            except (Stopped, OutOfTime):
                raise
            except SystemExit as left:
                if left.code:
                    self.later(left)
            except BaseException as error:  # a process would end with it, too
                self.later(error)

        return target

    @contextmanager
    def of_threads(self) -> Iterator[None]:
        """Hear of the exceptions that end threads."""
        before = threading.excepthook

        def hook(told: threading.ExceptHookArgs) -> None:
            if told.exc_value is not None:
                self.later(told.exc_value, told.thread.name if told.thread else "")

        threading.excepthook = hook
        try:
            yield
        finally:
            threading.excepthook = before

    def later(self, error: BaseException, thread: str = "") -> None:
        """Tell of it when the threads wait."""
        self._scheduler.clock.after(0, partial(self.take, error, thread))

    def take(self, error: BaseException, thread: str = "") -> None:
        """Tell of the first one; what follows from it is not told."""
        if not self._told:
            self._told = True
            self._ended(ended_by(error, self._files, thread))


def ended_by(error: BaseException, files: set[str], thread: str) -> Ended:
    """What an exception says of a master whose files are known."""
    place = _innermost(error.__traceback__, files)
    where = f" in {place}" if place else ""
    whose = f", thread {thread!r}" if thread else ""
    try:
        text = " ".join(str(error).split())
    except Exception:  # the class is the user's
        text = ""
    if isinstance(error, SimulatedTimeError):
        return Ended(f"{text}{where}{whose}", place, its_own=isinstance(error, HangError))
    told = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return Ended(f"{told}{where}{whose}", place, its_own=True)


def _innermost(trace: TracebackType | None, files: set[str]) -> str:
    lines = [frame for frame in traceback.extract_tb(trace) if frame.filename in files]
    return f"{Path(lines[-1].filename).name}:{lines[-1].lineno}" if lines else ""


@contextmanager
def _seeded(seed: int) -> Iterator[None]:
    """Chance is the same in every run: `random`, `uuid4`, `secrets` and `os.urandom`.

    So are the names of threads that are given none.
    """
    chance = random.Random(seed)
    state, urandom = random.getstate(), os.urandom
    system, number = vars(random)["_urandom"], vars(threading)["_counter"]
    vars(threading)["_counter"] = count(1).__next__
    random.seed(seed)
    os.urandom = chance.randbytes
    vars(random)["_urandom"] = chance.randbytes
    try:
        yield
    finally:
        random.setstate(state)
        os.urandom = urandom
        vars(random)["_urandom"] = system
        vars(threading)["_counter"] = number


class ExitCalled(BaseException):
    """A master has called `os._exit`, which would have ended the verdict with it."""


@contextmanager
def _no_exit() -> Iterator[None]:
    """`os._exit` ends the master and not us; a process that it has forked ends as it says."""
    ours, leave = os.getpid(), os._exit

    def told(status: int) -> NoReturn:
        if os.getpid() != ours:
            leave(status)
        raise ExitCalled(f"os._exit({status})")

    vars(os)["_exit"] = told
    try:
        yield
    finally:
        vars(os)["_exit"] = leave
