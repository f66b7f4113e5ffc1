"""Puts stand-ins into modules in the place of what waits in real time, and takes them out again.

What stands in is found by the identity of the value it stands for, so that it does not matter under
which name a module has imported it.
"""

import importlib
import queue
import sched
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from operator import is_
from threading import get_ident
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any, NoReturn, TypeGuard, TypeVar

import can
import can.broadcastmanager
import can.thread_safe_bus
import canopen.profiles.p402

from canopen_twins.bench.limits import place_of
from canopen_twins.bench.simulated_time import primitives
from canopen_twins.bench.simulated_time.bus import Notifier
from canopen_twins.bench.simulated_time.scheduler import Scheduler

T = TypeVar("T")

PYTHON_CAN = (
    can,
    can.broadcastmanager,
    can.bus,
    can.interface,
    can.listener,
    can.notifier,
    can.thread_safe_bus,
)
"""The modules of python-can that wait."""

REFUSED = {
    "asyncio": "use canopen's blocking calls",
    "concurrent.futures": "use threading.Thread and queue.Queue",
    "multiprocessing": "other processes have clocks of their own",
    "select": "wait for frames through canopen or python-can",
    "selectors": "wait for frames through canopen or python-can",
    "socket": "wait for frames through canopen or python-can",
    "subprocess": "other processes have clocks of their own",
}
"""What waits where no simulated time passes, and what to do about it."""


def _event(real: threading.Event) -> primitives.Event:
    event = primitives.Event()
    if real.is_set():
        event.set()
    return event


def _queue(real: queue.Queue[Any]) -> primitives.Queue:
    items = primitives.Queue(real.maxsize)
    for item in real.queue:
        items.put(item)
    return items


MADE_BEFORE: dict[type, Callable[[Any], object]] = {
    type(threading.Lock()): lambda _: primitives.Lock(),
    type(threading.RLock()): lambda _: primitives.RLock(),
    threading.Event: _event,
    queue.Queue: _queue,
}
"""What stands in for what a module made when it was imported."""


class StandIn(ModuleType):
    """A module with some names of its own; the others are those of the real one."""

    def __init__(self, module: ModuleType, names: Mapping[str, object]) -> None:
        super().__init__(module.__name__)
        self.__dict__.update(names)
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)


class RefusedModule(ModuleType):
    """A module whose functions and classes refuse to be used; constants and exceptions do not."""

    def __init__(self, module: ModuleType, scheduler: Scheduler) -> None:
        super().__init__(module.__name__)
        self._module = module
        self._scheduler = scheduler

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._module, name)
        advice = REFUSED[self._module.__name__]
        return _refused(value, advice, self._scheduler) if _refusable(value) else value


class StandIns:
    """Finds what stands in for a value of the real world."""

    def __init__(self, scheduler: Scheduler, open_bus: Callable[..., can.BusABC]) -> None:
        self._scheduler = scheduler
        self._known: dict[int, object] = {id(can.Bus): open_bus, id(can.Notifier): Notifier}
        for module, names in _own(scheduler).items():
            self._known[id(module)] = StandIn(module, names)
            self._known |= {id(getattr(module, name)): own for name, own in names.items()}

    def find(self, value: object) -> object:
        """What stands in for a value; the value itself if nothing needs to."""
        if (known := self._known.get(id(value))) is not None:
            return known
        if (make := MADE_BEFORE.get(type(value))) is not None:
            self._known[id(value)] = own = make(value)  # the same one in every module
            return own
        if is_a(value, ModuleType):
            return self._of_module(value)
        if _refusable(value) and (origin := _origin(value)):
            return _refused(value, REFUSED[origin], self._scheduler)
        return value

    def _of_module(self, module: ModuleType) -> ModuleType:
        """Refused itself, or with what is refused of it, as `concurrent` has `futures`."""
        if module.__name__ in REFUSED:
            return RefusedModule(module, self._scheduler)
        below = {
            name.rpartition(".")[2]: RefusedModule(sys.modules[name], self._scheduler)
            for name in REFUSED
            if name.rpartition(".")[0] == module.__name__ and name in sys.modules
        }
        return StandIn(module, below) if below else module


def _own(scheduler: Scheduler) -> dict[ModuleType, Mapping[str, object]]:
    own, wall = primitives, primitives.WallClock(scheduler)
    locks = (own.Lock, own.RLock, own.Condition, own.Event, own.Semaphore, own.BoundedSemaphore)
    threads = (own.Thread, own.Timer)
    queues = (own.Queue, own.LifoQueue, own.PriorityQueue, own.SimpleQueue)
    return {
        threading: {
            **{kind.__name__: kind for kind in locks + threads},
            "Barrier": _refused(threading.Barrier, "use threading.Condition", scheduler),
        },
        queue: {kind.__name__: kind for kind in queues},
        time: wall.functions(),
        sched: {"scheduler": wall.scheduler()},
    }


def is_a(value: object, kind: type[T]) -> TypeGuard[T]:
    """As `isinstance`, but asks the value nothing: canopen has a network that raises whatever."""
    return issubclass(type(value), kind)


def _origin(value: Any) -> str:
    """The refused module from which a class or function is, empty if from none."""
    module = value.__module__ or ""
    return next((name for name in REFUSED if f"{module}.".startswith(f"{name}.")), "")


def _refusable(value: object) -> bool:
    if is_a(value, type):
        return not issubclass(value, BaseException)
    return is_a(value, FunctionType) or is_a(value, BuiltinFunctionType)


def _refused(value: Any, advice: str, scheduler: Scheduler) -> Callable[..., NoReturn]:
    def refuse(*_: object, **__: object) -> NoReturn:
        name = f"{value.__module__}.{value.__qualname__}"
        raise scheduler.refusal(f"{name} cannot wait in simulated time: {advice}")

    return refuse


_surveyed: dict[ModuleType, tuple[list[object], list[str]]] = {}
"""The values of modules when they were looked through, and the names of those that wait."""


class Substitution:
    """Modules that wait in simulated time until `undo`."""

    def __init__(self, stand_ins: StandIns) -> None:
        self._stand_ins = stand_ins
        self._globals: list[tuple[ModuleType | type, str, object]] = []
        self._bases: list[tuple[type, tuple[type, ...]]] = []

    def apply(self, modules: Iterable[ModuleType]) -> None:
        """Put stand-ins in the place of whatever waits in real time."""
        for module in modules:
            for name, value in list(vars(module).items()):
                self._apply_to(module, name, value)

    def apply_to_canopen(self) -> None:
        """The same to canopen and python-can, in which one look finds the few names that matter."""
        for module in modules_of_canopen():
            values = list(vars(module).values())
            before, names = _surveyed.get(module, ([], []))
            if len(before) != len(values) or not all(map(is_, before, values)):
                names = [
                    name
                    for name, value in list(vars(module).items())
                    if self._apply_to(module, name, value)
                ]
                _surveyed[module] = values, names
            else:
                for name in names:
                    self._apply_to(module, name, vars(module)[name])

    def _apply_to(self, module: ModuleType, name: str, value: object) -> bool:
        """Whether there was anything to replace."""
        before = len(self._globals) + len(self._bases)
        if is_a(value, type) and value.__module__ == module.__name__:
            self._rebase(value)
            self._replace_made(value)
        elif not name.startswith("__"):
            self._replace(module, name, value)
        return len(self._globals) + len(self._bases) > before

    def refuse_sleep(self, scheduler: Scheduler, watched: Iterable[ModuleType]) -> None:
        """Let the real `time.sleep` refuse to stop simulated time, as it is or in these modules."""
        real = time.sleep

        def sleep(seconds: float) -> None:
            if scheduler.knows_caller:
                raise scheduler.refusal(
                    f"time.sleep would wait in real time, at {place_of(get_ident())}: name that"
                    " module, too, as in simulated_time(bench, 'my_master', __name__)"
                )
            real(seconds)

        self._set(time, "sleep", sleep)
        for module in watched:
            for name in [name for name, value in vars(module).items() if value is real]:
                self._set(module, name, sleep)

    def undo(self) -> None:
        """Leave everything as it was."""
        for module, name, value in self._globals:
            setattr(module, name, value)
        for kind, bases in self._bases:
            kind.__bases__ = bases

    def _replace(self, module: ModuleType | type, name: str, value: object) -> None:
        stand_in = self._stand_ins.find(value)
        if stand_in is not value:
            self._set(module, name, stand_in)

    def _replace_made(self, kind: type) -> None:
        """A lock that all of a class share was made when its module was imported."""
        for name, value in list(vars(kind).items()):
            if type(value) in MADE_BEFORE:
                self._replace(kind, name, value)

    def _set(self, module: ModuleType | type, name: str, value: object) -> None:
        self._globals.append((module, name, getattr(module, name)))
        setattr(module, name, value)

    def _rebase(self, kind: type) -> None:
        """A class of the master's that inherits from `threading.Thread` inherits from ours."""
        bases = kind.__bases__
        found = tuple(map(self._stand_ins.find, bases))
        new = tuple(base for base in found if isinstance(base, type))
        if new != bases and new == found:
            self._bases.append((kind, bases))
            kind.__bases__ = new


def modules_of_canopen() -> list[ModuleType]:
    """Where canopen and python-can wait."""
    return [*_with_submodules(canopen), *PYTHON_CAN]


def modules_named(names: Iterable[ModuleType | str]) -> list[ModuleType]:
    """Modules by themselves or by name; a package brings what has been imported of it.

    Raises:
        ImportError: there is no module of this name.
    """
    found = [importlib.import_module(name) if isinstance(name, str) else name for name in names]
    return [module for package in found for module in _with_submodules(package)]


def _with_submodules(package: ModuleType) -> list[ModuleType]:
    prefix = f"{package.__name__}."
    below = [module for name, module in sys.modules.items() if name.startswith(prefix)]
    return [package, *below]
