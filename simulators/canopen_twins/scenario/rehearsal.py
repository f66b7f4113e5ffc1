"""Who takes part: each a device without power, on which steps are tried while the file is read.

What it refuses is pointed at there, so that a typo never reaches the bus.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import Device
from canopen_twins.device.faults import OTHER_WORDS, Fault, argument
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown
from canopen_twins.faults import connect
from canopen_twins.files.document import Item, Pair, Reported
from canopen_twins.scenario import schema
from canopen_twins.scenario.scenario import NodeSpec
from canopen_twins.scenario.targets import Targets

Find = Callable[[str], type[Device]]
SEED, TIMING = "seed", "timing"
BESIDE = {"node_id": "node id", TIMING: TIMING}
"""What stands beside the settings of a node, not among them."""


class Rehearsal:
    """A node that follows the steps as far as settings and faults go."""

    def __init__(self, node: Node, objects: Targets, seed: int | None) -> None:
        self.name = node.wire.name
        self.objects = objects
        self._device = node.device
        self.knows = node.device.knows
        self._faults = node.faults
        self._seed = seed

    def set(self, given: Mapping[Item, Item]) -> dict[str, Any]:
        """Live settings and objects; what the device does not take becomes a problem."""
        taken = {}
        for name, value in given.items():
            with name.problems.at(value if self._device.knows(name.text) else name):
                self._device.set(**{name.text: value.value})
                taken[name.text] = value.value
        return taken

    def inject(self, name: Item, given: Mapping[Item, Item], heals: bool) -> dict[str, Any]:
        """The parameters of a fault; what it does not take becomes a problem.

        A fault that heals later is gone for the steps below.

        Raises:
            UserError: no such fault, or it misses something, cannot happen to this device, or
                never stays, so that it cannot heal.
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
        if heals:
            if fault.clear is None:
                raise name.wrong(
                    f"fault {name.text!r} is over at once: leave 'for' and 'until' out"
                )
            self._faults.clear(name.text)
        return taken

    @property
    def faults(self) -> Collection[str]:
        """What can go wrong with it."""
        return self._faults.known

    def clear(self, fault: str | None) -> None:
        """One fault, or all of them.

        Raises:
            UserError: no such fault.
        """
        self._faults.clear(fault)

    def _find(self, name: Item) -> Fault:
        return self._faults.known[name.one_of("fault", self._faults.known, OTHER_WORDS)]


class Participants:
    """The nodes of a file, on one bus, by their names; paths begin `beside` the file.

    One that cannot take part is a problem; what is told of it is not looked at.
    """

    def __init__(
        self, find: Find, beside: Path, seed: int | None = None, timing: str | None = None
    ) -> None:
        """`seed` and `timing` are for the nodes that have none of their own."""
        self.specs: dict[str, NodeSpec] = {}
        self._beside = beside
        self._find = find
        self._seed = seed
        self._timing = timing
        self._names: list[str] = []
        self._rehearsals: dict[str, Rehearsal] = {}
        self._bus: Segment[Node] = Segment()

    def take(self, name: str, node: schema.Node | None, place: Item) -> None:
        """Take one in; what is wrong with it and knows no place is blamed on this one."""
        self._names.append(name)
        with place.problems.at(place):
            if node is not None:
                spec, device = self._made(node)
                twin = connect(self._bus, device, name)
                self._rehearsals[name] = Rehearsal(twin, _objects(spec), self._seed)
                self.specs[name] = spec

    def rehearsal(self, name: Item | None, place: Item) -> Rehearsal:
        """That of a node by its name; of the only one if there is no name.

        Raises:
            UserError: there is no such node, or several to choose from.
        """
        names = self._names if name is None else [name.text]
        if name is not None and self._names:
            name.one_of("node", self._names)
        if len(names) > 1:
            raise place.wrong(f"'node' is missing: which of {', '.join(names)}")
        if not names or names[0] not in self._rehearsals:
            raise Reported
        return self._rehearsals[names[0]]

    @property
    def faults(self) -> set[str]:
        """What can go wrong with any of them."""
        return {name for each in self._rehearsals.values() for name in each.faults}

    @property
    def settings(self) -> set[str]:
        """What can be chosen of any of them."""
        return {name for spec in self.specs.values() for name in _settings(spec.device)}

    def knows(self, name: str) -> bool:
        """Whether one of them has a setting or an object of this name that can be set."""
        return any(each.knows(name) for each in self._rehearsals.values())

    def _made(self, node: schema.Node) -> tuple[NodeSpec, Device]:
        name = node.device.text
        with node.device.blamed():
            kind = self._find(str(self._beside / name) if devices.is_file(name) else name)
        given = _delivered(node.settings or {}, kind)
        if node.node_id is not None:
            given["node_id"] = node.node_id
        settings = {name: value.value for name, value in given.items()}
        timing = node.timing or self._timing
        if timing is not None and TIMING in _settings(kind):
            settings[TIMING] = timing
        if self._seed is not None and SEED in _settings(kind):
            settings.setdefault(SEED, self._seed)
        spec = NodeSpec(kind, settings)
        try:
            return spec, spec.create()
        except UserError:
            _blame(kind, given)
            raise


def _objects(spec: NodeSpec) -> Targets:
    kind: Any = spec.device  # which has a hash, as every class has
    return _objects_of(kind, tuple(spec.settings.items()))


@lru_cache(maxsize=8)  # a hunt reads the same nodes thousands of times
def _objects_of(kind: type[Device], settings: tuple[tuple[str, object], ...]) -> Targets:
    return Targets(kind(**dict(settings)).dictionary())


def _settings(kind: type[Device]) -> set[str]:
    return {field.name for field in fields(kind.settings)}


def _delivered(given: Mapping[Item, Item], kind: type[Device]) -> dict[str, Item]:
    known = _settings(kind) - BESIDE.keys()
    settings = {}
    for key, value in given.items():
        with key.problems.at(key):
            if key.text in BESIDE:
                told = BESIDE[key.text]
                raise key.wrong(f"the {told} stands beside the settings, not among them")
            if key.text not in known:
                raise unknown("setting", key.text, known)
            settings[key.text] = value
    return settings


def _blame(kind: type[Device], given: Mapping[str, Item]) -> None:
    """Raises the refusal of the first setting that is refused even by itself."""
    for name, item in given.items():
        with item.blamed():
            kind(**{name: item.value})
