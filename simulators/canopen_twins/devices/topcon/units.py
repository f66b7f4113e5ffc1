"""Unit types as a file lists them, such as od/topcon_units.yaml, and the stage of one of them."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache, partial
from pathlib import Path
from typing import Any

from canopen_twins.devices.topcon.model.loads import Load, parse_load
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.unit import UnitType
from canopen_twins.devices.topcon.settings import Settings
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item, Scalar, understand, values
from canopen_twins.files.shipped import od_file

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


def find(name: str, extra: str = "") -> UnitType:
    """The unit type of a name; a file of the user's comes before ours.

    Raises:
        UserError: there is none, or a file is not what it should be.
    """
    known = {**_shipped(), **(read_unit_types(Path(extra)) if extra else {})}
    if name not in known:
        raise unknown("unit type", name, known)
    return known[name]


@cache
def _shipped() -> Mapping[str, UnitType]:
    with od_file("topcon_units.yaml") as path:
        return read_unit_types(path)


def unit_type(settings: Settings) -> UnitType:
    """One unit of the system that the settings want.

    Raises:
        UserError: there is none of its name, or the figures of the system do not fit its objects.
    """
    unit = find(settings.unit, settings.unit_file)
    try:
        unit.system(settings.units, settings.connection)
    except ValueError as refusal:
        raise UserError(str(refusal)) from refusal
    return unit


def load(settings: Settings) -> Load:
    """What is connected to the output.

    Raises:
        UserError: no such load.
    """
    try:
        return parse_load(settings.load)
    except ValueError as refusal:
        raise UserError(f"setting 'load': {refusal}") from refusal


def output_stage(settings: Settings) -> OutputStage:
    """An output stage with its power just switched on; raises as `unit_type` and `load` do."""
    return OutputStage(
        unit_type(settings),
        load=load(settings),
        ambient=settings.ambient,
        units=settings.units,
        connection=settings.connection,
        boot_time=settings.ready_time,
        overvoltage_when_off=settings.ovp_when_off,
    )
