"""Puts stand-ins into the globals of modules, and takes every one of them out again."""

import importlib
import sys
from collections.abc import Iterable
from types import ModuleType

import can.broadcastmanager
import can.thread_safe_bus
import canopen.profiles.p402

from simulators.simulated_time.stand_ins import StandIns, is_a

PYTHON_CAN = (
    can,
    can.broadcastmanager,
    can.bus,
    can.interface,
    can.listener,
    can.notifier,
    can.thread_safe_bus,
)


class Substitution:
    """Modules that wait in simulated time until `undo`."""

    def __init__(self, stand_ins: StandIns) -> None:
        self._stand_ins = stand_ins
        self._globals: list[tuple[ModuleType, str, object]] = []
        self._bases: list[tuple[type, tuple[type, ...]]] = []

    def apply(self, modules: Iterable[ModuleType]) -> None:
        """Put stand-ins in the place of whatever waits in real time."""
        for module in modules:
            for name, value in list(vars(module).items()):
                if is_a(value, type) and value.__module__ == module.__name__:
                    self._rebase(value)
                elif not name.startswith("__"):
                    self._replace(module, name, value)

    def undo(self) -> None:
        """Leave everything as it was."""
        for module, name, value in self._globals:
            setattr(module, name, value)
        for kind, bases in self._bases:
            kind.__bases__ = bases

    def _replace(self, module: ModuleType, name: str, value: object) -> None:
        stand_in = self._stand_ins.find(value)
        if stand_in is not value:
            self._globals.append((module, name, value))
            setattr(module, name, stand_in)

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
