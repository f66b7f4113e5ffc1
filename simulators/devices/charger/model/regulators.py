"""Regulators of voltage, current and power: the one that wants least has its way."""

from collections.abc import Callable
from typing import NamedTuple

from simulators.devices.charger.model.load import Load
from simulators.devices.charger.model.types import Quantity

TOLERANCE = 1e-9  # of a setpoint: what is met exactly does not limit
BISECTIONS = 60


class Demand(NamedTuple):
    """What is asked of the charging output."""

    voltage: float  # V
    current: float  # A
    power: float  # W
    governing: Quantity
    ramp_time: int  # ms

    @property
    def target(self) -> float:
        """The setpoint the ramp leads to."""
        return self.current if self.governing is Quantity.CURRENT else self.voltage

    def at(self, reference: float) -> "Demand":
        """The same demand on the way there."""
        if self.governing is Quantity.CURRENT:
            return self._replace(current=reference)
        return self._replace(voltage=reference)


def regulate(demand: Demand, load: Load) -> tuple[float, Quantity]:
    """The voltage (V) at which a load settles, and the regulator that holds it there (A-54)."""
    voltage, regulator = demand.voltage, Quantity.VOLTAGE
    if load.current(voltage) > demand.current * (1 + TOLERANCE):
        voltage = highest_voltage(load.current, demand.current, voltage)
        regulator = Quantity.CURRENT
    if load.power(voltage) > demand.power * (1 + TOLERANCE):
        voltage = highest_voltage(load.power, demand.power, voltage)
        regulator = Quantity.POWER
    return voltage, regulator


def highest_voltage(rising: Callable[[float], float], limit: float, high: float) -> float:
    """The highest voltage up to `high` at which a rising quantity stays within its limit."""
    low = 0.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if rising(middle) <= limit:
            low = middle
        else:
            high = middle
    return low
