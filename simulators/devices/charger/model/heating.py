"""The temperature sensors of the charger and the losses that heat them (all figures assumed)."""

from collections.abc import Mapping

from simulators.devices.charger.model.thermal import Heat, Temperature

CASCADE_LOSS = 0.05  # of the charging power
SENSORS: Mapping[str, tuple[float, float]] = {  # K/W, s
    "power_stage": (1.2, 600.0),
    "inside": (0.6, 900.0),
    "cascade": (6.0, 400.0),
    "discharging": (20.0, 400.0),
}


class Heating:
    """All sensors together."""

    def __init__(self, *, discharging: bool) -> None:
        self._sensors = {
            name: Temperature(resistance, time_constant)
            for name, (resistance, time_constant) in SENSORS.items()
            if discharging or name != "discharging"
        }

    def at(self, now: int) -> Mapping[str, float]:
        """Every temperature in degC."""
        return {name: sensor.at(now) for name, sensor in self._sensors.items()}

    def lead(self, now: int, losses: Mapping[str, float], ambient: float, heat: Heat) -> None:
        """From `now` on there are these losses (W)."""
        for name, sensor in self._sensors.items():
            sensor.lead(now, losses[name], ambient, getattr(heat, name))

    def quiet(self, now: int) -> int:
        """Ticks until one of them reaches another whole degree."""
        return min(sensor.quiet(now) for sensor in self._sensors.values())


def losses(supply: float, charging: float, discharging: float) -> Mapping[str, float]:
    """What heats each sensor, from the powers (W) drawn and delivered."""
    stage = supply - charging - discharging
    return {
        "power_stage": stage,
        "inside": stage,
        "cascade": CASCADE_LOSS * charging,
        "discharging": discharging,
    }
