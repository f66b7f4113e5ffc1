"""What can go wrong with one of the control units, or with both."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any

from simulators.devices.gateway.model.machines import Gateway, Governor
from simulators.devices.gateway.model.timing import microseconds
from simulators.devices.gateway.model.unit import POWER_SUPPLY, Life
from simulators.errors import UserError, unknown
from simulators.faults import Fault, Parameter

if TYPE_CHECKING:
    from simulators.devices.gateway import Device

ControlUnit = Governor | Gateway
Act = Callable[..., None]

UNITS: Mapping[str, Callable[[Device], tuple[ControlUnit, ...]]] = {
    "gateway": lambda device: (device.system.gateway,),
    "governor": lambda device: (device.system.governor,),
    "both": lambda device: (device.system.governor, device.system.gateway),
}
BUFFERS = {"receive": "receive_overflow", "transmit": "transmit_overflow"}
NORMAL_SUPPLY = 24  # V


def faults(device: Device) -> Mapping[str, Fault]:
    """Those of the hardware and the programme; each says of which unit."""
    return {**_life(device), **_plug(device)}


def one_of(known: Collection[str], what: str, word: str) -> str:
    """A word that is known.

    Raises:
        UserError: it is not.
    """
    if word not in known:
        raise unknown(what, word, known)
    return word


def positive(what: str, number: float) -> float:
    """A number above 0.

    Raises:
        UserError: it is not.
    """
    if number <= 0:
        raise UserError(f"{what} {number:g} is not above 0")
    return number


def for_units(
    device: Device,
    text: str,
    act: Act,
    undo: Act | None = None,
    parameters: Mapping[str, Parameter] | None = None,
) -> Fault:
    """A fault whose parameter `unit` says to which units something is done."""

    def each(action: Act, unit: str, given: Mapping[str, Any]) -> None:
        for control_unit in UNITS[one_of(UNITS, "unit", unit)](device):
            try:
                action(control_unit, **given)
            except ValueError as refusal:
                raise UserError(str(refusal)) from refusal

    return Fault(
        text,
        lambda unit, **given: each(act, unit, given),
        None if undo is None else (lambda unit, **given: each(undo, unit, {})),
        {**(parameters or {}), "unit": Parameter(", ".join(UNITS), "gateway", str)},
    )


def _life(device: Device) -> Mapping[str, Fault]:
    def be_late(seconds: float) -> None:
        device.system.governor.boot_time = microseconds(round(positive("seconds", seconds), 3))
        restart(device.system.governor)

    def be_in_time() -> None:
        device.system.governor.boot_time = microseconds(device.settings.boot_time)

    return {
        "reset": for_units(device, "A control unit is reset (12411, 12419, or neither).", restart),
        "governor_late": Fault(
            "The governor starts, and takes its time (12422 after the delay 400).",
            be_late,
            lambda seconds: be_in_time(),
            {"seconds": Parameter("from now until its programme runs", 5.0)},
        ),
        "supply": for_units(
            device,
            "The supply is not 24 V (3085 below 7.5 V).",
            lambda unit, volts: unit.desk.show(POWER_SUPPLY, round(volts, 1)),
            lambda unit: unit.desk.show(POWER_SUPPLY, NORMAL_SUPPLY),
            {"volts": Parameter("0..55 V", 7.0)},
        ),
        "clear_errors": for_units(
            device,
            "Not a fault: somebody clears all errors, in both units (9.1).",
            lambda unit: unit.desk.clear_errors(),
        ),
    }


def _plug(device: Device) -> Mapping[str, Fault]:
    def overflow(unit: ControlUnit, buffer: str) -> None:
        setattr(unit.wiring, BUFFERS[one_of(BUFFERS, "buffer", buffer)], True)

    def empty(unit: ControlUnit) -> None:
        for name in BUFFERS.values():
            setattr(unit.wiring, name, False)

    return {
        "can1_bus_fault": for_units(
            device,
            "The HEINZMANN CAN controller of a unit reports a bus error (3070).",
            lambda unit: setattr(unit.wiring, "bus_fault", True),
            lambda unit: setattr(unit.wiring, "bus_fault", False),
        ),
        "duplicate_number": for_units(
            device,
            "Another unit has the type and number of this one (2404, 3071).",
            lambda unit: setattr(unit.wiring, "duplicate", True),
            lambda unit: setattr(unit.wiring, "duplicate", False),
        ),
        "heinzmann_overflow": for_units(
            device,
            "A buffer for the HEINZMANN CAN overflows (2401 or 2402, 3071).",
            overflow,
            empty,
            {"buffer": Parameter(", ".join(BUFFERS), "receive", str)},
        ),
    }


def hand_on(unit: ControlUnit) -> None:
    """Let the bootloader find nothing any more, and the unit start again."""
    if unit.bootloader.finding is not None:
        unit.bootloader.finding = None
        restart(unit)


def restart(unit: ControlUnit) -> None:
    """Reset a unit that has power."""
    if unit.life is not Life.OFF:
        unit.reset()
