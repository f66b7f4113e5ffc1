"""Errors from 3000 upward with a cause inside a control unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simulators.devices.gateway.model.bootloader import Finding
from simulators.devices.gateway.model.errors import INTERN
from simulators.devices.gateway.unit_faults import ControlUnit, for_units, hand_on, restart
from simulators.errors import UserError
from simulators.faults import Fault, Parameter

if TYPE_CHECKING:
    from simulators.devices.gateway import Device

FLASH_ERRORS = (3075, 3079)  # 9.3.2: the bootloader's own
OTHERWISE = {  # errors with a cause that is a fault of its own
    3070: "can1_bus_fault",
    3071: "duplicate_number",
    3072: "can2_bus_fault",
    3073: "can2_receive_overflow",
    3074: "reserved_identifier",
    3076: "bootloader",
    3078: "bootloader",
    3085: "supply",
    3087: "bootloader",
    3089: "watchdog",
}


def faults(device: Device) -> Mapping[str, Fault]:
    """Their numbers, and exceptions."""

    def mend(unit: ControlUnit) -> None:
        for number in unit.inner_faults:
            unit.mend(number)
        hand_on(unit)

    return {
        "error": for_units(
            device,
            "An error from 3000 upward has a cause within the unit, until it is cleared.",
            _fail,
            mend,
            {"number": Parameter("3001..3094", 3094, int)},
        ),
        "exception": for_units(
            device,
            "The programme runs into an exception (3094, told by 3195 to 3198).",
            lambda unit, number, address, flags: unit.break_off(number, address, flags),
            lambda unit: unit.mend(INTERN),
            {
                "number": Parameter("1 AND, 2 INTO, 3 watchdog", 1, int),
                "address": Parameter("where", 0, int),
                "flags": Parameter("of the processor", 0, int),
            },
        ),
    }


def _fail(unit: ControlUnit, number: int) -> None:
    if number in FLASH_ERRORS:
        unit.bootloader.finding = Finding(number)
        restart(unit)
    elif number in unit.inner_faults or number not in OTHERWISE:
        unit.fail(number)
    else:
        raise UserError(f"error {number} comes by the fault {OTHERWISE[number]!r}")
