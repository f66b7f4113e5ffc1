"""A campaign file: a contract, and the grid of all that is different from run to run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

from pydantic import ConfigDict, Discriminator, Field, Tag

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item
from canopen_twins.files.leaves import (
    HIGHEST,
    File,
    Name,
    Named,
    Scalar,
    Text,
    as_it_stands,
    whole,
)
from canopen_twins.files.table import Listed, understand_table
from canopen_twins.hunt.contract import Contract, Disturbance, Plan

MOST_RUNS = 1_000_000
ONCE = "a run is played once"
MOST_SEEDS = 100_000
NOTHING = "nothing"
DEVICE = "device"

ONE_OR_MANY = Discriminator(lambda found: "word" if found.is_word else "list")
Seeds = Annotated[
    Annotated[Annotated[int, whole(1, MOST_SEEDS)], Tag("word")]
    | Annotated[Listed[Annotated[int, whole(0, HIGHEST)]], Tag("list")],
    ONE_OR_MANY,
]
Raw = Annotated[Item, as_it_stands(lambda item: item.content, {"type": ["object", "string"]})]


class CampaignFile(File):
    """A contract, played with everything that is said here in all combinations."""

    model_config = ConfigDict(title="Campaign")

    contract: Text
    """The scenario file, from here."""
    master: Text = ""
    """Who is tested, MODULE:FUNCTION; that of the contract if it is left out."""
    devices: Annotated[Listed[Name], Field(min_length=1)] | None = None
    """Other devices for the one node of the contract, each in its turn."""
    settings: Named[Annotated[Listed[Scalar], Field(min_length=1)]] | None = None
    """At delivery: values by the name of a setting; by NODE.SETTING where there are several."""
    disturbances: Annotated[Listed[Raw], Field(min_length=1)] | None = None
    """One of these in each run, as in a scenario; a list for a parameter is one each. `nothing`."""
    seeds: Seeds = 1
    """How many, from 1 on, or which."""


@dataclass(frozen=True)
class Grid:
    """Every run of a campaign, in its order."""

    contract: Contract
    settings: tuple[tuple[str, str, tuple[Any, ...]], ...] = ()
    """Nodes, settings or `device`, and their values."""
    disturbances: tuple[Disturbance | None, ...] = ()
    seeds: tuple[int, ...] = (1,)

    def __len__(self) -> int:
        length = len(self.seeds) * max(len(self.disturbances), 1)
        for *_, values in self.settings:
            length *= len(values)
        return length

    def plans(self) -> Iterator[Plan]:
        """The last axis, that of the seeds, changes fastest."""
        axes = [[(node, name, value) for value in values] for node, name, values in self.settings]
        wrong = [() if told is None else (told,) for told in self.disturbances or (None,)]
        for settings, disturbances, seed in product(product(*axes), wrong, self.seeds):
            yield Plan(disturbances, settings, seed=seed)


def read_grid(path: Path, master: str = "") -> Grid:
    """The grid of a campaign file; `master` goes before that of the file.

    Raises:
        UserError: with a line for everything that is wrong, each with its place.
    """
    return understand_table(path, CampaignFile, lambda file: _grid(file, path, master))


def _grid(file: CampaignFile, path: Path, master: str) -> Grid:
    contract = Contract(path.parent / file.contract, master or file.master)
    if not contract.file.is_file():
        raise file.item_of("contract").wrong(f"there is no file {contract.file}")
    nodes = [*contract.scenario(Plan()).nodes]
    if file.devices and len(nodes) > 1:
        raise file.item_of("devices").wrong("the contract has several nodes")
    grid = Grid(
        contract,
        (*_devices(file.devices or (), nodes), *_settings(file.settings or {}, nodes)),
        tuple(_disturbances(file.disturbances or ())),
        tuple(range(1, file.seeds + 1) if isinstance(file.seeds, int) else file.seeds),
    )
    for key, told in (("seeds", grid.seeds), ("disturbances", map(repr, grid.disturbances))):
        for value, times in Counter(told).most_common(1):
            if times > 1:
                raise file.item_of(key).wrong(f"{value} stands there twice: {ONCE}")
    if len(grid) > MOST_RUNS:
        raise file.place.wrong(f"{len(grid)} runs are more than {MOST_RUNS}")
    _check(file, grid)
    return grid


Axis = tuple[str, str, tuple[Any, ...]]


def _devices(devices: Sequence[Item], nodes: Sequence[str]) -> Iterator[Axis]:
    if devices:
        _values(devices)
        yield nodes[0], DEVICE, tuple(device.text for device in devices)


def _settings(settings: Mapping[Item, Sequence[Item]], nodes: Sequence[str]) -> Iterator[Axis]:
    for key, values in settings.items():
        node, dot, name = key.text.rpartition(".")
        if not dot and len(nodes) > 1:
            raise key.wrong(f"of which node? Write NODE.{key.text}: {', '.join(nodes)}")
        if dot and node not in nodes:
            raise key.wrong(str(unknown("node", node, nodes)))
        yield node or nodes[0], name, _values(values)


def _values(items: Sequence[Item]) -> tuple[Any, ...]:
    """Each once, as a run is played once; `1` and `true` are two."""
    known: dict[str, Any] = {}
    for item in items:
        if repr(item.value) in known:
            raise item.wrong(f"{item.text} stands there twice: {ONCE}")
        known[repr(item.value)] = item.value
    return tuple(known.values())


def _disturbances(given: Sequence[Item]) -> Iterator[Disturbance | None]:
    for item in given:
        if not item.is_mapping:
            if item.text != NOTHING:
                raise item.wrong(f"{item.text!r}: wanted is {{at: 1, inject: ...}}, or {NOTHING}")
            yield None
        else:
            variants = [*_each(item.content)]
            if not variants:
                raise item.wrong("an empty list: there has to be a value to be played with")
            yield from variants


def _each(told: Mapping[str, Any]) -> Iterator[Disturbance]:
    """With every value of its lists."""
    keys = [*told]
    for values in product(*(_variants(told[key]) for key in keys)):
        yield dict(zip(keys, values, strict=True))


def _variants(value: Any) -> Sequence[Any]:
    if isinstance(value, Mapping):
        return [*_each(value)]
    return value if isinstance(value, list) else [value]


def _check(file: CampaignFile, grid: Grid) -> None:
    """What is not taken alone is told before anything is played."""
    blamed = [*(file.devices or ())[:1], *(file.settings or {})]
    for item, (node, name, values) in zip(blamed, grid.settings, strict=True):
        for value in values:
            _try(item, grid.contract, Plan(settings=((node, name, value),)))
    for item in file.disturbances or ():
        if item.is_mapping:
            for told in _each(item.content):
                _try(item, grid.contract, Plan(disturbances=(told,)))


def _try(item: Item, contract: Contract, plan: Plan) -> None:
    with item.problems.at(item):
        try:
            contract.scenario(plan)
        except UserError as refusal:
            raise item.wrong(_without_place(str(refusal))) from refusal


def _without_place(told: str) -> str:
    """The first line, less the place in a file that nobody has."""
    return told.splitlines()[0].split(": ", 1)[-1]
