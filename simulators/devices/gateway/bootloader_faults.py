"""What the bootloader of a control unit can find at the next start (9.3, 9.4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simulators.devices.gateway.model.bootloader import EndlessLoop
from simulators.devices.gateway.unit_faults import (
    ControlUnit,
    for_units,
    hand_on,
    one_of,
    restart,
)
from simulators.faults import Fault, Parameter

if TYPE_CHECKING:
    from simulators.devices.gateway import Device

LOOPS = {"watchdog": EndlessLoop.WATCHDOG, "checksum": EndlessLoop.CHECKSUM, "ram": EndlessLoop.RAM}


def faults(device: Device) -> Mapping[str, Fault]:
    """All of them restart the unit at once."""
    return {**_programme(device), **_bootloader(device)}


def _programme(device: Device) -> dict[str, Fault]:
    """The bootloader keeps the unit, and does not go on to the programme."""
    return {
        "bootloader": for_units(
            device,
            "A unit restarts, and a test keeps it in the bootloader (3078, 3087 or 3076; 3800).",
            _fail,
            hand_on,
            {"status": Parameter("3800 TestStatus, 1..10 (9.3.3)", 1, int)},
        ),
        "watchdog": for_units(
            device,
            "The watchdog ends the programme, and the bootloader keeps the unit (3089).",
            _bite,
            hand_on,
            {"address": Parameter("where the programme was", 0, int)},
        ),
    }


def _bootloader(device: Device) -> dict[str, Fault]:
    """What the bootloader finds at itself and its memory."""
    return {
        "endless_loop": for_units(
            device,
            "A unit restarts, and a test of the bootloader itself fails: not even DcDesk works.",
            _loop,
            hand_on,
            {"test": Parameter(", ".join(LOOPS), "checksum", str)},
        ),
        "eeprom": for_units(
            device,
            "A unit restarts, and finds pages of its EEPROM damaged (3099).",
            _damage,
            _repair,
            {"code": Parameter("3099: bits 0, 3, 4, 5, 6 (9.4)", 1, int)},
        ),
    }


def _fail(unit: ControlUnit, status: int) -> None:
    unit.bootloader.failed(status)
    restart(unit)


def _bite(unit: ControlUnit, address: int) -> None:
    unit.bootloader.watchdog_fired(address)
    restart(unit)


def _loop(unit: ControlUnit, test: str) -> None:
    unit.bootloader.finding = LOOPS[one_of(LOOPS, "test", test)]
    restart(unit)


def _damage(unit: ControlUnit, code: int) -> None:
    unit.bootloader.eeprom_code = code
    restart(unit)


def _repair(unit: ControlUnit) -> None:
    _damage(unit, 0)
