"""What current does to the unit in the long run: the heat sink, and the I2t store."""

from math import expm1, inf, log

from canopen_twins.devices.topcon.model.unit import UnitType

WARM = 80.0  # degC: warning, and the current limit begins to fall (assumed)
HOT = 95.0  # degC: trip (assumed)
LEAST = 0.5  # of the maximum current, at HOT (assumed)
HAIR = 1e-9  # a current of exactly the permitted one, but for its last bit, fills nothing


class HeatSink:
    """Temperature in degC; losses in W warm it above the ambient."""

    def __init__(self, unit: UnitType, temperature: float) -> None:
        self._resistance = unit.thermal_resistance
        self.time_constant = self._resistance * unit.thermal_capacity  # s
        self.temperature = temperature

    @property
    def derating(self) -> float:
        """Part of the maximum current it can carry: 1 when not warm, 0.5 and no less when hot."""
        if self.temperature <= WARM:
            return 1.0
        excess = (self.temperature - WARM) / (HOT - WARM)
        return 1.0 - (1.0 - LEAST) * min(excess, 1.0)

    def step(self, dt: float, loss: float, ambient: float) -> None:
        """`dt` seconds, of any length, at constant loss."""
        way = self.end(loss, ambient) - self.temperature
        self.temperature -= way * expm1(-dt / self.time_constant)

    def end(self, loss: float, ambient: float) -> float:
        """The temperature that `loss` leads to."""
        return ambient + loss * self._resistance

    def time_to(self, level: float, end: float) -> float:
        """Seconds until the temperature rises to `level` on its way to `end`; inf if never."""
        if not self.temperature < level < end:
            return inf
        return self.time_constant * log((end - self.temperature) / (end - level))


def derated_at(part: float) -> float:
    """The temperature at which only `part` of the maximum current is left; WARM at least."""
    return WARM + max(0.0, 1.0 - part) / (1.0 - LEAST) * (HOT - WARM)


class I2tStore:
    """Charge in A2s, never below 0; the unit warns at half its limit and trips at the limit."""

    def __init__(self, unit: UnitType) -> None:
        self._permitted = unit.i2t_current**2
        self.charge = 0.0

    def step(self, dt: float, current: float) -> None:
        """`dt` seconds, of any length, at constant current."""
        charge = self.charge + self._rate(current) * dt
        self.charge = charge if charge > 0.0 else 0.0

    def time_to(self, level: float, current: float) -> float:
        """Seconds until the charge rises to `level`; inf if never."""
        rate = self._rate(current)
        if rate <= 0.0 or self.charge >= level:
            return inf
        return (level - self.charge) / rate

    def _rate(self, current: float) -> float:
        rate = current**2 - self._permitted
        return rate if abs(rate) > HAIR * self._permitted else 0.0
