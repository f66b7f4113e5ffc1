"""Who takes part: devices, their node ids, and the settings they are delivered with."""

from collections.abc import Mapping
from dataclasses import fields as fields_of

from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown
from canopen_twins.faults import connect
from canopen_twins.files.document import Item
from canopen_twins.files.problems import Mistake, Noted, Placed
from canopen_twins.scenario import schema
from canopen_twins.scenario.load import Find
from canopen_twins.scenario.reading.dry_run import SEED, DryRun
from canopen_twins.scenario.scenario import NodeSpec


class Participants:
    """The nodes of a file, on one bus, each with a dry run of its steps.

    One that cannot take part is noted as a problem; what is told of it is not looked at.
    """

    def __init__(self, find: Find, seed: int | None = None) -> None:
        self.specs: dict[str, NodeSpec] = {}
        self._find = find
        self._seed = seed
        self._names: list[str] = []
        self._dry_runs: dict[str, DryRun] = {}
        self._bus: Segment[Node] = Segment()

    def take(self, name: Item, node: schema.Node | None, place: Item) -> None:
        """Take one in; what is wrong with it and knows no place is blamed on this one."""
        self._names.append(name.text)
        with place.problems.at(place):
            if node is not None:
                spec = self._spec(node)
                self._dry_runs[name.text] = DryRun(
                    connect(self._bus, spec.create(), name.text), self._seed
                )
                self.specs[name.text] = spec

    def dry_run(self, name: Item | None, place: Placed) -> DryRun:
        """That of a node by its name; of the only one if there is no name.

        Raises:
            UserError: there is no such node, or several to choose from.
        """
        names = self._names if name is None else [name.text]
        if name is not None and self._names:
            name.one_of("node", self._names)
        if len(names) > 1:
            raise Mistake(place.mark, f"'node' is missing: which of {', '.join(names)}")
        if not names or names[0] not in self._dry_runs:
            raise Noted
        return self._dry_runs[names[0]]

    def _spec(self, node: schema.Node) -> NodeSpec:
        with node.device.blamed():
            kind = self._find(node.device.text)
        given = _settings(node.settings or {}, kind)
        if node.node_id is not None:
            given["node_id"] = node.node_id
        settings = {name: value.value for name, value in given.items()}
        if self._seed is not None and SEED in _names(kind):
            settings.setdefault(SEED, self._seed)
        try:
            kind(**settings)
        except UserError:
            _blame(kind, given)
            raise
        return NodeSpec(kind, settings)


def _names(kind: type[Device]) -> set[str]:
    return {field.name for field in fields_of(kind.settings)}


def _settings(told: Mapping[Item, Item], kind: type[Device]) -> dict[str, Item]:
    known = _names(kind) - {"node_id"}
    settings = {}
    for key, value in told.items():
        with key.problems.at(key):
            if key.text == "node_id":
                raise key.wrong("the node id stands beside the settings, not among them")
            if key.text not in known:
                raise unknown("setting", key.text, known)
            settings[key.text] = value
    return settings


def _blame(kind: type[Device], given: Mapping[str, Item]) -> None:
    """Raises the refusal of the first setting that is refused even by itself."""
    for name, item in given.items():
        with item.blamed():
            kind(**{name: item.value})
