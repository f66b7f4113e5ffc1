"""Unit types as a file lists them, such as od/topcon_units.yaml."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache, partial
from pathlib import Path
from typing import Any

from canopen_twins.devices.topcon.model import OutputStage, UnitType, parse_load
from canopen_twins.devices.topcon.settings import Settings
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item, Scalar, understand, values
from canopen_twins.files.shipped import od_file

VERSION = 1
KINDS: Mapping[Any, Callable[[Item], Scalar]] = {
    str: lambda item: item.text,
    float: lambda item: item.number,
    bool: lambda item: item.truth,
}
FIGURES = {field.name: KINDS[field.type] for field in fields(UnitType)}
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


def output_stage(settings: Settings) -> OutputStage:
    """An output stage with its power just switched on.

    Raises:
        UserError: no such unit type or load, or figures that do not fit together.
    """
    unit = find(settings.unit, settings.unit_file)
    try:
        stage = OutputStage(
            unit,
            units=settings.units,
            connection=settings.connection,
            boot_time=settings.boot_time,
            ambient=settings.ambient,
            overvoltage_when_off=settings.ovp_when_off,
            noise=settings.noise,
            seed=settings.seed,
        )
    except ValueError as refusal:
        raise UserError(str(refusal)) from refusal
    surround(stage, settings)
    return stage


def surround(stage: OutputStage, settings: Settings) -> None:
    """Connect what is around the unit.

    Raises:
        UserError: no such load.
    """
    try:
        stage.load = parse_load(settings.load)
    except ValueError as refusal:
        raise UserError(f"setting 'load': {refusal}") from refusal
    stage.ambient = settings.ambient


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
