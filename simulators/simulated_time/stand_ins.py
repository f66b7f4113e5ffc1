"""What a module of the master finds instead of what waits in real time."""

import queue
import threading
import time
from collections.abc import Callable, Mapping
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any, NoReturn, TypeGuard, TypeVar

import can

from simulators.simulated_time import locks, queues, signals, threads
from simulators.simulated_time.baton import Baton
from simulators.simulated_time.bus import Notifier
from simulators.simulated_time.wall import Wall

T = TypeVar("T")

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


def _event(real: threading.Event) -> signals.Event:
    event = signals.Event()
    if real.is_set():
        event.set()
    return event


def _queue(real: queue.Queue[Any]) -> queues.Queue:
    items = queues.Queue(real.maxsize)
    for item in real.queue:
        items.put(item)
    return items


MADE_BEFORE: dict[type, Callable[[Any], object]] = {
    type(threading.Lock()): lambda _: locks.Lock(),
    type(threading.RLock()): lambda _: locks.RLock(),
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

    def __init__(self, module: ModuleType, baton: Baton) -> None:
        super().__init__(module.__name__)
        self._module = module
        self._baton = baton

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._module, name)
        advice = REFUSED[self._module.__name__]
        return _refused(value, advice, self._baton) if _refusable(value) else value


class StandIns:
    """Finds what stands in for a value of the real world, by identity: no name matters."""

    def __init__(self, baton: Baton, open_bus: Callable[..., can.BusABC]) -> None:
        self._baton = baton
        self._known: dict[int, object] = {id(can.Bus): open_bus, id(can.Notifier): Notifier}
        for module, names in _own(baton).items():
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
            refused = value.__name__ in REFUSED
            return RefusedModule(value, self._baton) if refused else value
        if _refusable(value) and (origin := _origin(value)):
            return _refused(value, REFUSED[origin], self._baton)
        return value


def _own(baton: Baton) -> dict[ModuleType, Mapping[str, object]]:
    here = (locks.Lock, locks.RLock, signals.Condition, signals.Event, signals.Semaphore)
    more = (signals.BoundedSemaphore, threads.Thread, threads.Timer)
    kinds = (queues.Queue, queues.LifoQueue, queues.PriorityQueue, queues.SimpleQueue)
    return {
        threading: {
            **{kind.__name__: kind for kind in here + more},
            "Barrier": _refused(threading.Barrier, "use threading.Condition", baton),
        },
        queue: {kind.__name__: kind for kind in kinds},
        time: Wall(baton).functions(),
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


def _refused(value: Any, advice: str, baton: Baton) -> Callable[..., NoReturn]:
    def refuse(*_: object, **__: object) -> NoReturn:
        name = f"{value.__module__}.{value.__qualname__}"
        raise baton.refusal(f"{name} cannot wait in simulated time: {advice}")

    return refuse
