"""The table of all objects and entries of the charger, whatever its type and variant."""

import csv
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from canopen_twins.device import Address
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.types import Build, Type
from canopen_twins.files.shipped import od_file

PARAMETERS = "2002"


@dataclass(frozen=True)
class Row:
    """An object, or with `type` an entry; what belongs to the type of charger is in braces."""

    index: str
    sub: str
    name: str
    object: str
    type: str
    access: str
    pdo: str
    default: str
    low: str
    high: str
    variants: str


@cache
def table() -> Sequence[Row]:
    """Every object and entry of the manual."""
    with od_file("charger_objects.csv") as path, path.open(newline="", encoding="ascii") as file:
        return [Row(**row) for row in csv.DictReader(file, strict=True)]


def file_name(build: Build) -> str:
    """The file of od/ that describes a charger."""
    parts = ["charger", build.kind.name, build.entries_of.value]
    return "_".join(filter(None, parts)).lower() + ".eds"


def rows_of(build: Build) -> Sequence[Row]:
    """The objects and entries of one type and variant."""
    variant = build.entries_of.value
    return [row for row in table() if not row.variants or variant in row.variants.split()]


@cache
def addresses(build: Build) -> Collection[Address]:
    """Where it has entries."""
    return {(int(row.index, 16), int(row.sub or "0", 16)) for row in rows_of(build) if row.type}


@cache
def factory(kind: Type) -> Mapping[Parameter, int]:
    """The factory setting of every parameter that the model knows, whatever the variant."""
    defaults = {row.sub: row.default for row in table() if row.index == PARAMETERS}
    return {
        parameter: int(filled(defaults[f"{parameter:02X}"], kind), 0) for parameter in Parameter
    }


def filled(cell: str, kind: Type) -> str:
    """A cell with what belongs to the type filled in."""
    return cell.format(**vars(kind))
