"""What can go wrong with one of the control units, or with both."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any

from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.devices.gateway.model.bootloader import EndlessLoop, Finding
from canopen_twins.devices.gateway.model.errors import INTERN
from canopen_twins.devices.gateway.model.machines import Gateway, Governor
from canopen_twins.devices.gateway.model.timing import microseconds
from canopen_twins.devices.gateway.model.unit import POWER_SUPPLY, Life
from canopen_twins.errors import UserError, unknown

if TYPE_CHECKING:
    from canopen_twins.devices.gateway import Device


ControlUnit = Governor | Gateway
Act = Callable[..., None]

UNITS: Mapping[str, Callable[[Device], tuple[ControlUnit, ...]]] = {
    "gateway": lambda device: (device.system.gateway,),
    "governor": lambda device: (device.system.governor,),
    "both": lambda device: (device.system.governor, device.system.gateway),
}
BUFFERS = {"receive": "receive_overflow", "transmit": "transmit_overflow"}
NORMAL_SUPPLY = 24  # V


def faults_of_units(device: Device) -> Mapping[str, Fault]:
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


LOOPS = {"watchdog": EndlessLoop.WATCHDOG, "checksum": EndlessLoop.CHECKSUM, "ram": EndlessLoop.RAM}


def faults_of_bootloaders(device: Device) -> Mapping[str, Fault]:
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


def faults_by_error(device: Device) -> Mapping[str, Fault]:
    """Their numbers, and exceptions."""

    def mend(unit: ControlUnit) -> None:
        for number in unit.inner_faults:
            unit.mend(number)
        hand_on(unit)

    return {
        "error": for_units(
            device,
            "An error from 3000 upward has a cause within the unit, until it is cleared.",
            _fail_inside,
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


def _fail_inside(unit: ControlUnit, number: int) -> None:
    if number in FLASH_ERRORS:
        unit.bootloader.finding = Finding(number)
        restart(unit)
    elif number in unit.inner_faults or number not in OTHERWISE:
        unit.fail(number)
    else:
        raise UserError(f"error {number} comes by the fault {OTHERWISE[number]!r}")
