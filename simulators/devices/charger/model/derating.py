"""Power setpoints that only the charger itself changes: less when it is hot or poorly fed."""

from collections.abc import Mapping

from simulators.devices.charger.model.ticks import NEVER, whole_ticks
from simulators.devices.charger.model.types import Type

REVIEW = whole_ticks(1.0)
SPAN = 15.0  # K from full power to none
FULL_POWER_UP_TO = {"power_stage": 70.0, "discharging": 65.0}  # degC
LOWEST_SUPPLY, FULL_SUPPLY = 18.0, 21.0  # V


class Derating:
    """2002h:0Ah and 20h in W, by the sensor that decides; worked out once a second (assumed)."""

    def __init__(self, kind: Type) -> None:
        self._maxima = {"power_stage": kind.power, "discharging": kind.power_discharging}
        self._setpoints = dict(self._maxima)

    @property
    def charging(self) -> float:
        """Power setpoint of the charging, W."""
        return self._setpoints["power_stage"]

    @property
    def discharging(self) -> float:
        """Power setpoint of the discharging, W."""
        return self._setpoints["discharging"]

    def review(self, now: int, temperatures: Mapping[str, float], supply_voltage: float) -> None:
        """Work it out anew if the second is over."""
        if now % REVIEW == 0:
            self._setpoints = self._allowed(temperatures, supply_voltage)

    def quiet(self, now: int, temperatures: Mapping[str, float], supply_voltage: float) -> int:
        """Ticks until something may change."""
        warm = any(
            full <= temperatures.get(sensor, 0.0) < full + SPAN
            for sensor, full in FULL_POWER_UP_TO.items()
        )
        if warm or self._allowed(temperatures, supply_voltage) != self._setpoints:
            return REVIEW - now % REVIEW
        return NEVER

    def _allowed(
        self, temperatures: Mapping[str, float], supply_voltage: float
    ) -> dict[str, float]:
        supply = _share((supply_voltage - LOWEST_SUPPLY) / (FULL_SUPPLY - LOWEST_SUPPLY))
        return {
            sensor: maximum * supply * _share(_coolness(sensor, temperatures))
            for sensor, maximum in self._maxima.items()
        }


def _coolness(sensor: str, temperatures: Mapping[str, float]) -> float:
    """1 up to where full power is allowed, 0 where none is; a sensor that is not there is cold."""
    return (FULL_POWER_UP_TO[sensor] + SPAN - temperatures.get(sensor, 0.0)) / SPAN


def _share(value: float) -> float:
    return max(0.0, min(1.0, value))
