"""Unit types, ours and those of a user's file, and the stage of one of them."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from canopen_twins.devices.topcon.model.loads import Load, parse_load
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.unit import UnitType
from canopen_twins.devices.topcon.settings import Settings
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.shipped import od_file

TRUTH = {"true": True, "false": False}


def find(name: str, extra: str = "") -> UnitType:
    """The unit type of a name; a file of the user's comes before ours.

    Raises:
        UserError: there is none, or a file is not what it should be.
    """
    known = {**shipped(), **(_of_file(Path(extra)) if extra else {})}
    if name not in known:
        raise unknown("unit type", name, known)
    return known[name]


def _of_file(path: Path) -> Mapping[str, UnitType]:
    from canopen_twins.devices.topcon.unit_file import read_unit_types  # noqa: PLC0415 - see `shipped`

    return read_unit_types(path)


@cache
def shipped() -> Mapping[str, UnitType]:
    """Our unit types by their names.

    Of YAML our file has no more than keys and values, line by line: the import of PyYAML and the
    checks of a file of the user's took a quarter of the time to the first twin of a process.
    """
    types: list[dict[str, Any]] = []
    with od_file("topcon_units.yaml") as path:
        lines = path.read_text("utf-8").partition("\ntypes:\n")[2].splitlines()
    for line in lines:
        key, _, figure = line.partition("#")[0].strip().partition(": ")
        if key.startswith("- "):
            types.append({})
        if key:
            types[-1][key.removeprefix("- ")] = _figure(figure)
    return {each["name"]: UnitType(**each) for each in types}


def _figure(text: str) -> str | float | bool:
    if text in TRUTH:
        return TRUTH[text]
    if text.isdecimal():
        return int(text)
    try:
        return float(text)
    except ValueError:
        return text


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
    """An output stage, cold and empty; raises as `unit_type` and `load` do."""
    return OutputStage(
        unit_type(settings),
        load=load(settings),
        ambient=settings.ambient,
        units=settings.units,
        connection=settings.connection,
        boot_time=settings.ready_time,
        cooldown=settings.cooldown,
        overvoltage_when_off=settings.ovp_when_off,
    )
