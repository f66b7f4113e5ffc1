"""What can go wrong with one of the control units, or with both: a row for each fault."""

from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Any

from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.devices.gateway.model.bootloader import EndlessLoop, Finding
from canopen_twins.devices.gateway.model.errors import INTERN
from canopen_twins.devices.gateway.model.gateway import Gateway
from canopen_twins.devices.gateway.model.governor import Governor
from canopen_twins.devices.gateway.model.timing import microseconds
from canopen_twins.devices.gateway.model.unit import NORMAL_SUPPLY, Life
from canopen_twins.devices.gateway.units import Units
from canopen_twins.errors import UserError, unknown

ControlUnit = Governor | Gateway
Act = Callable[..., None]

WHICH: Mapping[str, Callable[[Units], tuple[ControlUnit, ...]]] = {
    "gateway": lambda units: (units.system.gateway,),
    "governor": lambda units: (units.system.governor,),
    "both": lambda units: (units.system.governor, units.system.gateway),
}
LOOPS = {"watchdog": EndlessLoop.WATCHDOG, "checksum": EndlessLoop.CHECKSUM, "ram": EndlessLoop.RAM}
BUFFERS = ("receive", "transmit")
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


def _of_unit(text: str, act: Act, undo: Act | None = None, **parameters: Parameter) -> Fault:
    """A fault whose parameter `unit` says to which units something is done."""

    def each(action: Act, units: Units, unit: str, given: Mapping[str, Any]) -> None:
        for control_unit in WHICH[one_of(WHICH, "unit", unit)](units):
            try:
                action(control_unit, **given)
            except ValueError as refusal:
                raise UserError(str(refusal)) from refusal

    return Fault(
        text,
        lambda units, unit, **given: each(act, units, unit, given),
        None if undo is None else (lambda units, unit, **_: each(undo, units, unit, {})),
        {**parameters, "unit": Parameter(", ".join(WHICH), "gateway", str, examples=tuple(WHICH))},
    )


def _restart(unit: ControlUnit) -> None:
    """Reset a unit that has power."""
    if unit.life is not Life.OFF:
        unit.reset()


def _be_late(units: Units, seconds: float) -> None:
    units.system.governor.boot_time = microseconds(round(positive("seconds", seconds), 3))
    _restart(units.system.governor)


def _be_in_time(units: Units, seconds: float) -> None:
    units.system.governor.boot_time = microseconds(units.settings.boot_time)


def _overflow(unit: ControlUnit, buffer: str) -> None:
    if one_of(BUFFERS, "buffer", buffer) == "receive":
        unit.wiring.receive_overflow = True
    else:
        unit.wiring.transmit_overflow = True


def _empty(unit: ControlUnit) -> None:
    unit.wiring.receive_overflow = unit.wiring.transmit_overflow = False


def _disturb(unit: ControlUnit, fault: bool = True) -> None:
    unit.wiring.bus_fault = fault


def _duplicate(unit: ControlUnit, present: bool = True) -> None:
    unit.wiring.duplicate = present


def _fail_inside(unit: ControlUnit, number: int) -> None:
    if number in FLASH_ERRORS:
        _keep(unit, Finding(number))
    elif number in unit.inner_faults or number not in OTHERWISE:
        unit.fail(number)
    else:
        raise UserError(f"error {number} comes by the fault {OTHERWISE[number]!r}")


def _mend(unit: ControlUnit) -> None:
    for number in unit.inner_faults:
        unit.mend(number)
    _hand_on(unit)


def _keep(unit: ControlUnit, finding: Finding | EndlessLoop) -> None:
    unit.bootloader.finding = finding
    _restart(unit)


def _hand_on(unit: ControlUnit) -> None:
    """Let the bootloader find nothing any more, and the unit start again."""
    if unit.bootloader.finding is not None:
        unit.bootloader.finding = None
        _restart(unit)


def _damage(unit: ControlUnit, code: int = 0) -> None:
    unit.bootloader.eeprom_code = code
    _restart(unit)


UNIT_FAULTS: Mapping[str, Fault] = {
    # its life
    "reset": _of_unit("A control unit is reset (12411, 12419, or neither).", _restart),
    "governor_late": Fault(
        "The governor starts, and takes its time (12422 after the delay 400).",
        _be_late,
        _be_in_time,
        {"seconds": Parameter("from now until its programme runs", 5.0, low=0)},
    ),
    "supply": _of_unit(
        "The supply is not 24 V (3085 below 7.5 V).",
        lambda unit, volts: unit.feed(volts),
        lambda unit: unit.feed(NORMAL_SUPPLY),
        volts=Parameter("0..55 V", 7.0, examples=(0.0, 16.0, 40.0)),
    ),
    "clear_errors": _of_unit(
        "Not a fault: somebody clears all errors, in both units (9.1).",
        lambda unit: unit.desk.clear_errors(),
    ),
    # its plug to the other unit
    "can1_bus_fault": _of_unit(
        "The HEINZMANN CAN controller of a unit reports a bus error (3070).",
        _disturb,
        partial(_disturb, fault=False),
    ),
    "duplicate_number": _of_unit(
        "Another unit has the type and number of this one (2404, 3071).",
        _duplicate,
        partial(_duplicate, present=False),
    ),
    "heinzmann_overflow": _of_unit(
        "A buffer for the HEINZMANN CAN overflows (2401 or 2402, 3071).",
        _overflow,
        _empty,
        buffer=Parameter(", ".join(BUFFERS), "receive", str),
    ),
    # by the number of an error
    "error": _of_unit(
        "An error from 3000 upward has a cause within the unit, until it is cleared.",
        _fail_inside,
        _mend,
        number=Parameter("3001..3094", 3094, int, examples=(3001, 3010, 3050)),
    ),
    "exception": _of_unit(
        "The programme runs into an exception (3094, told by 3195 to 3198).",
        lambda unit, number, address, flags: unit.break_off(number, address, flags),
        lambda unit: unit.mend(INTERN),
        number=Parameter("1 AND, 2 INTO, 3 watchdog", 1, int),
        address=Parameter("where", 0, int),
        flags=Parameter("of the processor", 0, int),
    ),
    # the bootloader: each restarts the unit at once
    "bootloader": _of_unit(
        "A unit restarts, and a test keeps it in the bootloader (3078, 3087 or 3076; 3800).",
        lambda unit, status: _keep(unit, Finding.of_test(status)),
        _hand_on,
        status=Parameter("3800 TestStatus, 1..10 (9.3.3)", 1, int),
    ),
    "watchdog": _of_unit(
        "The watchdog ends the programme, and the bootloader keeps the unit (3089).",
        lambda unit, address, flags: _keep(unit, Finding.of_watchdog(address, flags)),
        _hand_on,
        address=Parameter("where the programme was", 0, int),
        flags=Parameter("of the processor", 0, int),
    ),
    "endless_loop": _of_unit(
        "A unit restarts, and a test of the bootloader itself fails: not even DcDesk works.",
        lambda unit, test: _keep(unit, LOOPS[one_of(LOOPS, "test", test)]),
        _hand_on,
        test=Parameter(", ".join(LOOPS), "checksum", str, examples=tuple(LOOPS)),
    ),
    "eeprom": _of_unit(
        "A unit restarts, and finds pages of its EEPROM damaged (3099).",
        _damage,
        _damage,
        code=Parameter("3099: bits 0, 3, 4, 5, 6 (9.4)", 1, int),
    ),
}
