"""The I2t store: fills with current above the permitted, empties below it."""

from math import inf

from simulators.devices.topcon.model.unit import UnitType

HAIR = 1e-9  # a current of exactly the permitted one, but for its last bit, fills nothing


class I2tStore:
    """Charge in A2s, never below 0; the unit warns at half its limit and trips at the limit."""

    def __init__(self, unit: UnitType) -> None:
        self._unit = unit
        self.charge = 0.0

    def step(self, dt: float, current: float) -> None:
        """`dt` seconds, of any length, at constant current."""
        self.charge = max(0.0, self.charge + self._rate(current) * dt)

    def time_to(self, level: float, current: float) -> float:
        """Seconds until the charge rises to `level`; inf if never."""
        rate = self._rate(current)
        if rate <= 0.0 or self.charge >= level:
            return inf
        return (level - self.charge) / rate

    def _rate(self, current: float) -> float:
        permitted = self._unit.i2t_current**2
        rate = current**2 - permitted
        return rate if abs(rate) > HAIR * permitted else 0.0
