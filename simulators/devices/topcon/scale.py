"""Parts of 4000 on the wire, engineering units in the model (7.3.5-7.3.15)."""

from collections.abc import Mapping
from typing import NamedTuple

from simulators.devices.topcon.model import UnitType
from simulators.objects import Address, Object

FULL_SCALE = 4000  # parts that make up a nominal value
LOWEST, HIGHEST = -0x8000, 0x7FFF  # of signed 16 bit


class Quantity(NamedTuple):
    """A quantity with its nominal value, in its unit."""

    nominal: float

    def parts(self, value: float) -> int:
        """As it goes over the wire: rounded half away from zero, clipped to signed 16 bit."""
        parts = FULL_SCALE * value / self.nominal
        rounded = int(parts + 0.5) if parts >= 0 else -int(0.5 - parts)
        if LOWEST <= rounded <= HIGHEST:
            return rounded
        return HIGHEST if rounded > 0 else LOWEST

    def value(self, parts: int) -> float:
        """As the model has it."""
        return parts / FULL_SCALE * self.nominal


class Scale:
    """The nominal values of a unit (0x2000-0x2003), and what they scale."""

    def __init__(self, unit: UnitType) -> None:
        self.unit = unit
        self.voltage = Quantity(unit.nominal_voltage)
        self.current = Quantity(unit.maximum_current)
        self.power = Quantity(unit.nominal_power)
        self.resistance = Quantity(unit.nominal_resistance)

    @property
    def nominal_values(self) -> Mapping[Address, Object]:
        """What a value of 4000 parts stands for (7.3.1-7.3.4), in V, A, kW and mOhm."""
        return {
            (0x2000, 0): Object(read=lambda: round(self.unit.nominal_voltage)),
            (0x2001, 0): Object(read=lambda: round(self.unit.maximum_current)),
            (0x2002, 0): Object(read=lambda: round(self.unit.nominal_power / 1e3)),
            (0x2003, 0): Object(read=lambda: round(self.unit.nominal_resistance * 1e3)),
        }
