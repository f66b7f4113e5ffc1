"""A device without power, on which steps are tried while the file is read.

What it refuses is pointed at there, so that a typo never reaches the bus.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from simulators.device import Device
from simulators.documents.document import Item, Pair
from simulators.errors import unknown
from simulators.faults import argument
from simulators.replay.targets import Targets
from simulators.segment import Segment


class Rehearsal:
    """Follows the steps as far as settings and faults go."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._faults = Segment().node(device, "rehearsal").faults
        self.targets = Targets(device.dictionary())

    def set(self, item: Item) -> dict[str, Any]:
        """Live settings; notes as a problem what the device does not take."""
        known = [field.name for field in fields(self._device.settings_type)]
        taken = {}
        for name, pair in item.some_pairs.items():
            with item.problems.at(pair.place(known)):
                if name not in known:
                    raise unknown("setting", name, known)
                self._device.set(**{name: pair.value.value})
                taken[name] = pair.value.value
        return taken

    def inject(self, fault: Item, given: Mapping[str, Pair]) -> dict[str, Any]:
        """The parameters of a fault; notes as a problem what the fault does not take.

        Raises:
            UserError: no such fault, or it misses something, or cannot happen to this device.
        """
        known, taken = self._faults.known, {}
        name = fault.one_of("fault", known)
        for key, pair in given.items():
            with fault.problems.at(pair.place(known[name].parameters)):
                taken[key] = argument(name, known[name], key, pair.value.value)
        if len(taken) == len(given):
            self._faults.inject(name, **taken)
        return taken

    def clear(self, fault: str | None) -> None:
        """One fault, or all of them.

        Raises:
            UserError: no such fault.
        """
        self._faults.clear(fault)
