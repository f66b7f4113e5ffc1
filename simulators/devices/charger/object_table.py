"""The table of all objects and entries of the charger, whatever its type and variant."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from simulators.devices.charger.model.parameter import Parameter
from simulators.devices.charger.model.types import Type
from simulators.resources import od_file

TABLE = "charger_objects.csv"
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
    with od_file(TABLE) as path, path.open(newline="", encoding="ascii") as file:
        return [Row(**row) for row in csv.DictReader(file, strict=True)]


def factory(kind: Type) -> Mapping[Parameter, int]:
    """The factory setting of every parameter that the model knows, whatever the variant."""
    defaults = {row.sub: row.default for row in table() if row.index == PARAMETERS}
    return {
        parameter: int(filled(defaults[f"{parameter:02X}"], kind), 0) for parameter in Parameter
    }


def filled(cell: str, kind: Type) -> str:
    """A cell with what belongs to the type filled in."""
    return cell.format(**vars(kind))
