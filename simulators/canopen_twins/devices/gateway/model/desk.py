"""DcDesk on one control unit: reads and changes parameters, saves them, clears errors (7 to 9)."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from canopen_twins.devices.gateway.model.bootloader import FROM_BOOTLOADER, Eeprom
from canopen_twins.devices.gateway.model.errors import COUNTERS, MOST
from canopen_twins.devices.gateway.model.parameters import Catalogue, Parameter
from canopen_twins.devices.gateway.model.unit import ControlUnit, Life

SERIAL = (3844, 3845)


def _error(unit: ControlUnit[Any], number: int) -> float:
    in_bootloader = unit.life is Life.BOOTLOADER
    return unit.bootloader.shows(number) if in_bootloader else unit.memory.has(number)


def _exception(unit: ControlUnit[Any], number: int) -> float:
    damaged = unit.bootloader.damaged(Eeprom.EXCEPTION)
    return 0 if damaged else unit.exception[number - 3195]


def _serial(unit: ControlUnit[Any], number: int) -> float:
    return 0 if unit.bootloader.damaged(Eeprom.SERIAL_NUMBER) else unit.shown[number]


READERS: Mapping[Iterable[int], Callable[[ControlUnit[Any], int], float]] = {
    range(3000, 3095): _error,
    range(3100, 3195): lambda unit, number: unit.memory.counts.get(number - COUNTERS, 0),
    (3099,): lambda unit, _: unit.bootloader.eeprom_code,
    (*range(3095, 3099), *range(3800, 3804)): lambda unit, number: unit.bootloader.shows(number),
    range(3195, 3199): _exception,
    (3600,): lambda unit, _: round(unit.supply, 1),
    (3870,): lambda unit, _: unit.timer,
    SERIAL: _serial,
}
BY_NUMBER = {number: read for numbers, read in READERS.items() for number in numbers}


def measured(unit: ControlUnit[Any], number: int) -> float:
    """The present value of a measurement, in its unit; a number the unit has is presumed."""
    if number in unit.live:
        return unit.live[number]()
    return BY_NUMBER[number](unit, number) if number in BY_NUMBER else unit.shown[number]


IDENTIFIER, LAST_IDENTIFIER = 3850, 3851
PC_HIGH, PC_LOW = 2424, 2425
SHOWN = (
    *(2406, PC_HIGH, PC_LOW, *range(3840, 3846), IDENTIFIER, LAST_IDENTIFIER, 3865),
    *range(3895, 3899),
)
"""Measurements that nothing in the model makes."""


class Desk:
    """Gets and sets by number or name; everything that is refused is a ValueError of one line."""

    def __init__(self, unit: ControlUnit[Any], catalogue: Catalogue) -> None:
        self._unit, self._catalogue = unit, catalogue

    def parameter(self, key: int | str) -> Parameter:
        """The parameter with this number or name.

        Raises:
            ValueError: the unit has none.
        """
        return self._catalogue.find(self._unit.which, key)

    def read(self, key: int | str) -> float:
        """The value of a parameter, in its unit.

        Raises:
            ValueError: no such parameter, or the unit does not answer for it now.
        """
        parameter = self.parameter(key)
        self._check_answering(parameter)
        if parameter.writable:
            return self._unit.store.shown(parameter.number)
        return measured(self._unit, parameter.number)

    def write(self, key: int | str, value: float) -> None:
        """Change a parameter; it acts after `save` and a reset of the unit (7).

        Raises:
            ValueError: no such parameter, out of range, only shown, or no answer.
        """
        parameter = self._writable(key)
        self._check_answering(parameter)
        self._unit.store.edit(parameter.number, parameter.checked(value))

    def checked(self, values: Mapping[Any, Any]) -> dict[int, float]:
        """Values by number, from values by number or name.

        Raises:
            ValueError: no such parameter, out of range, only shown, or given twice.
        """
        found: dict[int, float] = {}
        for key, value in values.items():
            parameter = self._writable(key)
            if parameter.number in found:
                raise ValueError(f"{parameter.title}: is given twice")
            found[parameter.number] = parameter.checked(value)
        return found

    def deliver(self, values: Mapping[int, float]) -> None:
        """Keep checked values as if the unit had come with them; they act at the next reset."""
        self._unit.store.deliver(values)

    def save(self) -> None:
        """Keep what was changed, and which PC did it (8.3)."""
        self._unit.store.save()
        self._unit.shown[LAST_IDENTIFIER] = self._unit.shown[IDENTIFIER]

    def show(self, key: int | str, value: float) -> None:
        """Set what a measurement shows that nothing in the model makes: versions, RAM test.

        Raises:
            ValueError: not one of these measurements, or out of range.
        """
        parameter = self.parameter(key)
        if parameter.number not in SHOWN:
            raise ValueError(f"{parameter.title}: comes about by itself")
        self._unit.shown[parameter.number] = parameter.checked(value)

    def connect(self, node: int = 0, identifier: int = 0) -> None:
        """Connect a PC with DcDesk: node number on the HEINZMANN CAN, identification of the PC."""
        nodes = 1 << node if node else 0
        self._unit.shown |= {PC_HIGH: nodes >> 16, PC_LOW: nodes & 0xFFFF, IDENTIFIER: identifier}

    def clear_errors(self) -> None:
        """Clear all errors, which clears them in the other unit too (9.1)."""
        if self._unit.programme is not None:
            self._unit.programme.clear_errors()

    def clear_error_memory(self) -> None:
        """Clear the permanent error memory (9.2)."""
        self._unit.memory.clear_counts()

    def _writable(self, key: int | str) -> Parameter:
        parameter = self.parameter(key)
        if not parameter.writable:
            raise ValueError(f"{parameter.title}: is only shown")
        return parameter

    def _check_answering(self, parameter: Parameter) -> None:
        unit = self._unit
        in_bootloader = unit.life is Life.BOOTLOADER and not unit.bootloader.silent
        if unit.life is Life.RUNNING:
            return
        if not (in_bootloader and parameter.number in FROM_BOOTLOADER):
            raise ValueError(f"{parameter.title}: no answer, the unit is {unit.life.value}")

    @property
    def kept(self) -> dict[str, Any]:
        """What the unit keeps without power, as values for a file: parameters, counters, exception.

        The last identification as well (8.3).
        """
        unit = self._unit
        counts = unit.memory.counts
        return {
            "parameters": {str(number): value for number, value in unit.store.saved.items()},
            "errors": {str(number + COUNTERS): counts[number] for number in sorted(counts)},
            "exception": list(unit.exception),
            "last identifier": unit.shown[LAST_IDENTIFIER],
        }

    def restore(self, values: Mapping[str, Any]) -> None:
        """Begin with what was kept; what is not given stays as it is.

        Raises:
            ValueError: something in it is not what this unit keeps.
        """
        unit = self._unit
        try:
            self.deliver(
                self.checked({int(n): each for n, each in values.get("parameters", {}).items()})
            )
            for number, count in values.get("errors", {}).items():
                unit.memory.counts[int(number) - COUNTERS] = min(max(0, int(count)), MOST)
            first, second, third, fourth = values.get("exception", unit.exception)
            unit.exception = (int(first), int(second), int(third), int(fourth))
            self.show(LAST_IDENTIFIER, values.get("last identifier", 0))
        except (AttributeError, TypeError) as reason:
            raise ValueError(f"{unit.which.value}: not what was kept: {reason}") from None
