"""A contract and a plan for one run of it: together they are a scenario, as text and as such.

Whatever a hunt plays is the text that it would write as a find, so that a find is no translation.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import yaml

from canopen_twins import devices
from canopen_twins.bench.python_master import PythonMaster
from canopen_twins.errors import UserError
from canopen_twins.files.document import understand
from canopen_twins.files.writer import node_of, write_yaml
from canopen_twins.scenario import Scenario, load
from canopen_twins.scenario.rehearsal import BESIDE

WALL = 20.0
"""Seconds of real time for a run that is done in a tenth of one: who takes longer hangs."""
OF_A_HUNT = ("weather", "space")
OF_A_NODE = ("device", *BESIDE)
LAST = ("steps", "disturbances", "recovers", "cleanup")

Disturbance = Mapping[str, Any]
"""As it stands in a file: plain values by their keys."""


@dataclass(frozen=True)
class Plan:
    """What goes wrong in one run, and what else is different in it."""

    disturbances: tuple[Disturbance, ...] = ()
    settings: tuple[tuple[str, str, Any], ...] = ()
    """At delivery: the name of a node, of a setting, and its value."""
    heals: bool = True
    """Whether everything heals, so that the master has to be back."""
    left_out: tuple[int, ...] = ()
    """Parts of the contract that are left out: its steps, then what it always wants, then
    `recovers`, counted from 0."""
    seed: int | None = None
    """Where chance begins, if not as the contract says."""
    order: tuple[str, ...] = ()
    """The nodes as they stand in the file: who comes first at one microsecond; none: as there."""

    arbitration: str = ""
    """Who is on the bus first at one microsecond, as a file has it; empty: as the contract says."""

    @property
    def key(self) -> str:
        """What makes it this one."""
        wrong = sorted(repr(each) for each in self.disturbances)
        settings = sorted(map(repr, self.settings))
        return repr(
            (wrong, settings, self.heals, self.left_out, self.seed, self.order, self.arbitration)
        )

    @property
    def size(self) -> int:
        """How many things are beyond the contract."""
        return (
            len(self.disturbances) + len(self.settings) + bool(self.order) + bool(self.arbitration)
        )

    @property
    def faults(self) -> tuple[str, ...]:
        """What goes wrong, by name."""
        return tuple(map(what, self.disturbances))


def what(disturbance: Disturbance) -> str:
    """What goes wrong, in a word: the fault, or what is done."""
    if "inject" in disturbance:
        told = disturbance["inject"]
        return told if isinstance(told, str) else next(iter(told))
    return "power" if "power" in disturbance else f"set {', '.join(disturbance['set'])}"


@dataclass(frozen=True)
class Contract:
    """A file, and who is tested, `MODULE:FUNCTION`; empty: the master of the file."""

    file: Path
    master: str = ""
    command: tuple[str, ...] = ()
    """A master in another process, beside twins in real time; none: it is a function."""
    hub: str = ""
    """Where its buses are."""

    def text(
        self, plan: Plan, named: Mapping[str, object] | None = None, folder: Path | None = None
    ) -> str:
        """The file of a run: its `named` keys go before those of the contract.

        With a folder it is to lie there: its paths begin there, and it is about one run alone.

        Raises:
            UserError: the file cannot be read, or is no YAML of ours.
        """
        pairs = dict(_pairs(self.file, _stamp(self.file)))
        pairs.setdefault("steps", yaml.SequenceNode("", []))  # all else may be left out
        for key, value in (named or {}).items():
            pairs[key] = node_of(value)
        if plan.seed is not None:
            pairs["seed"] = node_of(plan.seed)
        if self.command:
            pairs.pop("master", None)
        elif self.master:
            pairs["master"] = node_of(self.master)
        _leave_out(pairs, plan.left_out)
        if plan.order:
            nodes = {key.value: node for key, node in pairs["nodes"].value}
            pairs["nodes"] = node_of({name: nodes[name] for name in plan.order})
        if plan.arbitration:
            pairs["arbitration"] = node_of(plan.arbitration)
        if plan.disturbances:
            before = pairs.get("disturbances", yaml.SequenceNode("", []))
            added = [node_of(each) for each in plan.disturbances]
            pairs["disturbances"] = yaml.SequenceNode("", [*before.value, *added])
        for name, key, value in plan.settings:
            _deliver(pairs, name, key, node_of(value))
        if folder is not None:
            pairs = {key: value for key, value in pairs.items() if key not in OF_A_HUNT}
            beside = partial(_beside, self.file.resolve().parent, folder.resolve())
            pairs |= {key: beside(pairs[key]) for key in ("node", "nodes") if key in pairs}
        if not plan.heals:
            pairs.pop("recovers", None)
        order = [key for key in pairs if key not in LAST] + [key for key in LAST if key in pairs]
        return "".join(_written(key, pairs[key]) for key in order)

    def scenario(self, plan: Plan) -> Scenario:
        """A run of it.

        Raises:
            UserError: it says what cannot be.
        """
        if plan == Plan():  # whose lines are told are those of the file
            scenario = load(self.file)
            if self.master:
                scenario = replace(scenario, master=PythonMaster.beside(self.master, self.file))
        else:
            scenario = load(self.file, text=self.text(plan))
        if scenario.master is None or self.command:
            return replace(scenario, master=None)
        return replace(scenario, master=replace(scenario.master, wall=WALL))

    @property
    def parts(self) -> int:
        """How many steps it has, with what it always wants, and `recovers`."""
        return len(_parts(_pairs(self.file, _stamp(self.file))))


def _parts(pairs: Mapping[str, yaml.Node]) -> list[tuple[str, int]]:
    """By key and place; steps first."""
    lists = {key: pairs.get(key) for key in ("steps", "always")}
    found = [
        (key, n)
        for key, node in lists.items()
        if isinstance(node, yaml.SequenceNode)
        for n in range(len(node.value))
    ]
    return [*found, ("recovers", 0)] if "recovers" in pairs else found


def _leave_out(pairs: dict[str, yaml.Node], numbers: Collection[int]) -> None:
    gone = {part for n, part in enumerate(_parts(pairs)) if n in numbers}
    if ("recovers", 0) in gone:
        del pairs["recovers"]
    for key in {key for key, _ in gone} & {"steps", "always"}:
        node = pairs[key]
        assert isinstance(node, yaml.SequenceNode)
        kept = [each for n, each in enumerate(node.value) if (key, n) not in gone]
        pairs[key] = yaml.SequenceNode("", kept)
        if not kept and key == "always":
            del pairs[key]


def _stamp(file: Path) -> int:
    return file.stat().st_mtime_ns if file.is_file() else 0


@lru_cache(maxsize=8)
def _pairs(file: Path, stamp: int) -> Mapping[str, yaml.Node]:
    node = understand(file, lambda item: item.node)
    if not isinstance(node, yaml.MappingNode):
        raise UserError(f"{file} is no scenario")
    return {key.value: value for key, value in node.value}


@lru_cache(maxsize=64)
def _written(key: str, node: yaml.Node) -> str:
    """Most of a contract is the same in every run."""
    return write_yaml(node_of({key: node}))


def _deliver(pairs: dict[str, yaml.Node], name: str, key: str, value: yaml.Node) -> None:
    """Let a node be delivered with a setting."""
    path = (key,) if key in OF_A_NODE else ("settings", key)
    if "node" in pairs:
        pairs["node"] = _with(pairs["node"], path, value)
    else:
        pairs["nodes"] = _with(pairs["nodes"], (name, *path), value)


def _beside(here: Path, there: Path, node: yaml.Node) -> yaml.Node:
    """The same nodes, with the paths of devices as they are from another folder."""
    if not isinstance(node, yaml.MappingNode):
        return node
    pairs = {key.value: _beside(here, there, value) for key, value in node.value}
    if isinstance(told := pairs.get("device"), yaml.ScalarNode) and devices.is_file(told.value):
        pairs["device"] = node_of(os.path.relpath(here / told.value, there))
    return node_of(pairs)


def _with(node: yaml.Node, path: Sequence[str], value: yaml.Node) -> yaml.Node:
    """The same mapping, with another value behind a path of keys."""
    pairs = {key.value: inner for key, inner in node.value}
    first, *others = path
    inner = pairs.get(first, yaml.MappingNode("", []))
    pairs[first] = _with(inner, others, value) if others else value
    return node_of(pairs)
