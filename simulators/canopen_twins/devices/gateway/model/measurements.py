"""What a control unit shows: errors, counters, exceptions, and what its programme measures."""

from typing import Any

from canopen_twins.devices.gateway.model.bootloader import Eeprom
from canopen_twins.devices.gateway.model.errors import COUNTERS, FIRST
from canopen_twins.devices.gateway.model.unit import ControlUnit, Life

ERRORS = range(FIRST, FIRST + 95)
BOOTLOADER_EXCEPTION = range(3095, 3099)
EEPROM_CODE = 3099
COUNTS = range(FIRST + COUNTERS, FIRST + COUNTERS + 95)
EXCEPTION = range(3195, 3199)
BOOTLOADER_TEST = range(3800, 3804)
SERIAL = (3844, 3845)


STORED = frozenset(
    (*ERRORS, *BOOTLOADER_EXCEPTION, EEPROM_CODE, *COUNTS, *EXCEPTION, *BOOTLOADER_TEST, *SERIAL)
)


def measured(unit: ControlUnit[Any], number: int) -> float:
    """The present value of a measurement, in its unit; a number the unit has is presumed."""
    if number in unit.live:
        return unit.live[number]()
    if number not in STORED:
        return unit.shown[number]
    if number in ERRORS and unit.life is not Life.BOOTLOADER:
        return int(unit.memory.has(number))
    if number in ERRORS or number in BOOTLOADER_EXCEPTION or number in BOOTLOADER_TEST:
        return unit.bootloader.shows(number)
    if number in COUNTS:
        return unit.memory.counts.get(number - COUNTERS, 0)
    return _kept(unit, number)


def _kept(unit: ControlUnit[Any], number: int) -> float:
    """What is read from the EEPROM, or just shown."""
    damaged = unit.bootloader.damaged
    if number == EEPROM_CODE:
        return unit.bootloader.eeprom_code
    if number in EXCEPTION:
        return 0 if damaged(Eeprom.EXCEPTION) else unit.exception[number - EXCEPTION.start]
    if number in SERIAL and damaged(Eeprom.SERIAL_NUMBER):
        return 0
    return unit.shown[number]
