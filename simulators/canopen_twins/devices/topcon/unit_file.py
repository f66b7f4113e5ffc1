"""Unit types as a file lists them, such as od/topcon_units.yaml."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import partial
from pathlib import Path
from typing import Any

from canopen_twins.devices.topcon.model.unit import UnitType
from canopen_twins.errors import UserError
from canopen_twins.files.document import Item, understand, values
from canopen_twins.files.yaml_nodes import Scalar

VERSION = 1
READERS: Mapping[Any, Callable[[Item], Scalar]] = {
    str: lambda item: item.text,
    float: lambda item: item.number,
    bool: lambda item: item.truth,
}
FIGURES = {field.name: READERS[field.type] for field in fields(UnitType)}
OPTIONAL = [field.name for field in fields(UnitType) if field.default is not MISSING]


def read_unit_types(path: Path) -> Mapping[str, UnitType]:
    """The unit types of a file by their names.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    return understand(path, _unit_types)


def _unit_types(file: Item) -> Mapping[str, UnitType]:
    units: dict[str, UnitType] = {}
    values(file, {"version": _check_version, "types": partial(_read_types, units=units)})
    return units


def _check_version(version: Item) -> None:
    if version.whole != VERSION:
        raise version.wrong(f"version {version.text} is unknown; this is {VERSION}")


def _read_types(types: Item, units: dict[str, UnitType]) -> None:
    if not types.items:
        raise types.wrong("empty; at least one unit type is wanted here")
    for entry in types.items:
        with entry.problems.at(entry):
            unit = _unit_type(values(entry, FIGURES, OPTIONAL))
            if unit.name in units:
                raise UserError(f"unit type {unit.name!r} stands above already")
            units[unit.name] = unit


def _unit_type(figures: Mapping[str, Any]) -> UnitType:
    try:
        return UnitType(**figures)
    except ValueError as refusal:
        raise UserError(str(refusal)) from refusal
