"""The heat sink: one thermal resistance, one capacity, and what the converter may still carry."""

from math import expm1, inf, log

from simulators.devices.topcon.model.unit import UnitType

WARM = 80.0  # degC: warning, and the current limit begins to fall (assumed)
HOT = 95.0  # degC: trip (assumed)
LEAST = 0.5  # of the maximum current, at HOT (assumed)


class HeatSink:
    """Temperature in degC; losses in W warm it above the ambient."""

    def __init__(self, unit: UnitType, temperature: float) -> None:
        self._unit = unit
        self.temperature = temperature

    @property
    def time_constant(self) -> float:
        """Seconds."""
        return self._unit.thermal_resistance * self._unit.thermal_capacity

    @property
    def derating(self) -> float:
        """Part of the maximum current it can carry: 1 when not warm, 0.5 and no less when hot."""
        excess = (self.temperature - WARM) / (HOT - WARM)
        return 1.0 - (1.0 - LEAST) * min(max(excess, 0.0), 1.0)

    def step(self, dt: float, loss: float, ambient: float) -> None:
        """`dt` seconds, of any length, at constant loss."""
        way = self.end(loss, ambient) - self.temperature
        self.temperature -= way * expm1(-dt / self.time_constant)

    def end(self, loss: float, ambient: float) -> float:
        """The temperature that `loss` leads to."""
        return ambient + loss * self._unit.thermal_resistance

    def time_to(self, level: float, end: float) -> float:
        """Seconds until the temperature rises to `level` on its way to `end`; inf if never."""
        if not self.temperature < level < end:
            return inf
        return self.time_constant * log((end - self.temperature) / (end - level))


def derated_at(part: float) -> float:
    """The temperature at which only `part` of the maximum current is left; WARM at least."""
    return WARM + max(0.0, 1.0 - part) / (1.0 - LEAST) * (HOT - WARM)
