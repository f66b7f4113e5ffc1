"""Unit types as a file lists them: every key checked before a unit is built."""

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from typing import Any

from simulators.devices.topcon.model.hints import did_you_mean
from simulators.devices.topcon.model.unit import UnitType

FIELDS: dict[str, "Field[Any]"] = {field.name: field for field in fields(UnitType)}
REQUIRED = [field.name for field in fields(UnitType) if field.default is MISSING]
VERSION = 1
KINDS: dict[Any, tuple[tuple[type, ...], str]] = {
    str: ((str,), "text"),
    float: ((int, float), "a number"),
    bool: ((bool,), "true or false"),
}


def unit_types(data: Mapping[str, Any]) -> dict[str, UnitType]:
    """Unit types by name, from the content of a file such as od/topcon_units.yaml.

    Raises ValueError with one line that says which entry is wrong, and how.
    """
    _refuse_unknown(data, ("version", "types"), "unit types")
    if data.get("version") != VERSION:
        raise ValueError(f"unit types: version must be {VERSION}, not {data.get('version')!r}")
    units: dict[str, UnitType] = {}
    for place, entry in enumerate(_entries(data), 1):
        unit = _unit_type(entry, place)
        if unit.name in units:
            raise ValueError(f"unit type {unit.name!r} is listed twice")
        units[unit.name] = unit
    return units


def _entries(data: Mapping[str, Any]) -> list[Any]:
    entries = data.get("types")
    if not isinstance(entries, list) or not entries:
        raise ValueError("unit types: 'types' must be a list of one unit type or more")
    return entries


def _unit_type(entry: Any, place: int) -> UnitType:
    if not isinstance(entry, Mapping):
        raise ValueError(f"unit type {place} must be a mapping, not {entry!r}")
    where = f"unit type {entry.get('name', place)!r}"
    _refuse_unknown(entry, FIELDS, where)
    for name in REQUIRED:
        if name not in entry:
            raise ValueError(f"{where}: {name!r} is missing")
    for name, value in entry.items():
        _check_kind(name, value, where)
    return UnitType(**entry)


def _refuse_unknown(entry: Mapping[str, Any], known: Any, where: str) -> None:
    for key in entry:
        if key not in known:
            raise ValueError(f"{where}: {key!r} is unknown{did_you_mean(key, known)}")


def _check_kind(name: str, value: Any, where: str) -> None:
    kinds, expected = KINDS[FIELDS[name].type]
    if type(value) not in kinds:  # YAML reads 5e-4 as text; 5.0e-4 and 0.0005 are numbers
        raise ValueError(f"{where}: {name} must be {expected}, not {value!r}")
