"""Unit types from od/topcon_units.yaml and a file of the user's; a stage of such a type."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from simulators.devices.topcon.model import OutputStage, UnitType, parse_load
from simulators.devices.topcon.settings import Settings
from simulators.devices.topcon.unit_file import read_unit_types
from simulators.errors import UserError, unknown
from simulators.resources import od_file


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
