"""Temperatures: each an exponential towards what the present losses would heat it to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import exp, floor, log

from canopen_twins.devices.charger.model.ticks import NEVER, TICK, whole_ticks
from canopen_twins.devices.charger.model.types import Type

AMBIENT = 25.0  # degC
CASCADE_LOSS = 0.05  # of the charging power
SENSORS: Mapping[str, tuple[float, float]] = {  # K/W, s
    "power_stage": (1.2, 600.0),
    "inside": (0.6, 900.0),
    "cascade": (6.0, 400.0),
    "discharging": (20.0, 400.0),
}
REVIEW = whole_ticks(1.0)
SPAN = 15.0  # K from full power to none
FULL_POWER_UP_TO = {"power_stage": 70.0, "discharging": 65.0}  # degC
LOWEST_SUPPLY, FULL_SUPPLY = 18.0, 21.0  # V


@dataclass
class Temperature:
    """One sensor, worked out from the last change of the losses: exact for steps of any length."""

    resistance: float  # K/W
    time_constant: float  # s
    _start: float = AMBIENT  # degC
    _end: float = field(init=False)
    _since: int = field(default=0, init=False)
    _heat: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self._end = self._start

    def at(self, now: int) -> float:
        """The temperature at a tick, in degC."""
        elapsed = (now - self._since) * TICK
        course = (self._start - self._end) * exp(-elapsed / self.time_constant)
        return self._end + course + self._heat

    def begin(self, now: int, temperature: float) -> None:
        """Be at a temperature (degC) at a tick, its heat from elsewhere included."""
        self._start, self._since = temperature - self._heat, now

    def lead(self, now: int, power: float, ambient: float, heat: float) -> None:
        """From `now` on there is a loss of `power` (W) in a surrounding of `ambient` (degC)."""
        end = ambient + self.resistance * power
        if end != self._end:
            self._start, self._end, self._since = self.at(now) - self._heat, end, now
        self._heat = heat

    def quiet(self, present: float) -> int:
        """Ticks from the temperature at present until another whole degree, or a little less."""
        end = self._end + self._heat
        whole = floor(present)
        falling = end < present
        boundary = whole if falling else whole + 1
        if not (end < boundary if falling else end > boundary):
            return NEVER
        seconds = self.time_constant * log((present - end) / (boundary - end))
        return max(1, floor(seconds / TICK))


class Heating:
    """All sensors together."""

    def __init__(self, start: float = AMBIENT, *, discharging: bool) -> None:
        """As warm as its surroundings, `start` degC."""
        self._sensors = {
            name: Temperature(resistance, time_constant, start)
            for name, (resistance, time_constant) in SENSORS.items()
            if discharging or name != "discharging"
        }
        self._seen: tuple[int, Mapping[str, float]] | None = None  # what is asked for several times

    def at(self, now: int) -> Mapping[str, float]:
        """Every temperature in degC."""
        if self._seen is None or self._seen[0] != now:
            self._seen = now, {name: sensor.at(now) for name, sensor in self._sensors.items()}
        return self._seen[1]

    def inherit(self, temperatures: Mapping[str, float], now: int) -> None:
        """Go on with temperatures (degC) of a former life, as far as losses explain them."""
        self._seen = None
        for name, sensor in self._sensors.items():
            sensor.begin(now, temperatures[name])

    def lead(
        self, now: int, losses: Mapping[str, float], ambient: float, heat: Mapping[str, float]
    ) -> None:
        """From `now` on there are these losses (W), and so many K on top of what they explain."""
        self._seen = None
        for name, sensor in self._sensors.items():
            sensor.lead(now, losses[name], ambient, heat.get(name, 0.0))

    def quiet(self, now: int) -> int:
        """Ticks until one of them reaches another whole degree."""
        present = self.at(now)
        return min([sensor.quiet(present[name]) for name, sensor in self._sensors.items()])


def losses(supply: float, charging: float, discharging: float) -> Mapping[str, float]:
    """What heats each sensor, from the powers (W) drawn and delivered."""
    stage = supply - charging - discharging
    return {
        "power_stage": stage,
        "inside": stage,
        "cascade": CASCADE_LOSS * charging,
        "discharging": discharging,
    }


class Derating:
    """2002h:0Ah and 20h in W, by the supply and the sensor that decides.

    They follow the supply and a sudden heat at once, the slow course of a temperature once a
    second (assumed).
    """

    def __init__(self, kind: Type) -> None:
        self._maxima = {"power_stage": kind.power, "discharging": kind.power_discharging}
        self._cool = dict.fromkeys(self._maxima, 1.0)  # shares of full power
        self._fed = 1.0
        self._heat: Mapping[str, float] = {}

    @property
    def charging(self) -> float:
        """Power setpoint of the charging, W."""
        return self._setpoint("power_stage")

    @property
    def discharging(self) -> float:
        """Power setpoint of the discharging, W."""
        return self._setpoint("discharging")

    def review(
        self,
        now: int,
        temperatures: Mapping[str, float],
        supply_voltage: float,
        heat: Mapping[str, float],
    ) -> None:
        """Work it out anew; `heat` (K) is what comes on top of the losses all of a sudden."""
        self._fed = _share((supply_voltage - LOWEST_SUPPLY) / (FULL_SUPPLY - LOWEST_SUPPLY))
        if now % REVIEW == 0 or heat != self._heat:
            self._heat, self._cool = heat, self._coolness(temperatures)

    def quiet(self, now: int, temperatures: Mapping[str, float]) -> int:
        """Ticks until something may change."""
        warm = any(
            full <= temperatures.get(sensor, 0.0) < full + SPAN
            for sensor, full in FULL_POWER_UP_TO.items()
        )
        if warm or self._coolness(temperatures) != self._cool:
            return REVIEW - now % REVIEW
        return NEVER

    def _setpoint(self, sensor: str) -> float:
        return self._maxima[sensor] * self._fed * self._cool[sensor]

    def _coolness(self, temperatures: Mapping[str, float]) -> dict[str, float]:
        return {sensor: _share(_coolness(sensor, temperatures)) for sensor in self._maxima}


def _coolness(sensor: str, temperatures: Mapping[str, float]) -> float:
    """1 up to where full power is allowed, 0 where none is; a sensor that is not there is cold."""
    return (FULL_POWER_UP_TO[sensor] + SPAN - temperatures.get(sensor, 0.0)) / SPAN


def _share(value: float) -> float:
    return max(0.0, min(1.0, value))
