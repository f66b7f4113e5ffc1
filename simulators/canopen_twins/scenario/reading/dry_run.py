"""A device without power, on which steps are tried while the file is read.

What it refuses is pointed at there, so that a typo never reaches the bus.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from canopen_twins.device.faults import Fault, argument
from canopen_twins.device.node import Node
from canopen_twins.errors import unknown
from canopen_twins.files.document import Item, Pair
from canopen_twins.scenario.targets import Targets

SEED = "seed"


class DryRun:
    """Follows the steps as far as settings and faults go."""

    def __init__(self, node: Node, seed: int | None) -> None:
        self.name = node.wire.name
        self.targets = Targets(node.device.dictionary())
        self._device = node.device
        self._faults = node.faults
        self._seed = seed

    def set(self, given: Mapping[Item, Item]) -> dict[str, Any]:
        """Live settings; notes as a problem what the device does not take."""
        known = [field.name for field in fields(self._device.settings)]
        taken = {}
        for name, value in given.items():
            with name.problems.at(Pair(name, value).place(known)):
                if name.text not in known:
                    raise unknown("setting", name.text, known)
                self._device.set(**{name.text: value.value})
                taken[name.text] = value.value
        return taken

    def inject(self, name: Item, given: Mapping[Item, Item]) -> dict[str, Any]:
        """The parameters of a fault; notes as a problem what the fault does not take.

        Raises:
            UserError: no such fault, or it misses something, or cannot happen to this device.
        """
        fault = self._find(name)
        taken = {}
        for key, value in given.items():
            with name.problems.at(Pair(key, value).place(fault.parameters)):
                taken[key.text] = argument(name.text, fault, key.text, value.value)
        if len(taken) == len(given):
            if self._seed is not None and SEED in fault.parameters:
                taken.setdefault(SEED, self._seed)
            self._faults.inject(name.text, **taken)
        return taken

    def heal(self, name: Item) -> None:
        """The fault goes by itself later, so it is gone for the steps below.

        Raises:
            UserError: it never stays.
        """
        if self._find(name).clear is None:
            raise name.wrong(f"fault {name.text!r} is over at once: leave 'for' and 'until' out")
        self._faults.clear(name.text)

    def clear(self, fault: str | None) -> None:
        """One fault, or all of them.

        Raises:
            UserError: no such fault.
        """
        self._faults.clear(fault)

    def _find(self, name: Item) -> Fault:
        return self._faults.known[name.one_of("fault", self._faults.known)]
