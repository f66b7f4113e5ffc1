"""Temperatures: each an exponential towards what the present losses would heat it to."""

from dataclasses import dataclass, field
from math import exp, floor, log
from typing import NamedTuple

from simulators.devices.charger.model.ticks import NEVER, TICK

AMBIENT = 25.0  # degC


class Heat(NamedTuple):
    """Heat from outside, such as a blocked fan, in K on top of each temperature."""

    power_stage: float = 0.0
    inside: float = 0.0
    cascade: float = 0.0
    discharging: float = 0.0


@dataclass
class Temperature:
    """One sensor, worked out from the last change of the losses: exact for steps of any length."""

    resistance: float  # K/W
    time_constant: float  # s
    _start: float = field(default=AMBIENT, init=False)  # degC
    _end: float = field(default=AMBIENT, init=False)
    _since: int = field(default=0, init=False)
    _heat: float = field(default=0.0, init=False)

    def at(self, now: int) -> float:
        """The temperature at a tick, in degC."""
        elapsed = (now - self._since) * TICK
        course = (self._start - self._end) * exp(-elapsed / self.time_constant)
        return self._end + course + self._heat

    def lead(self, now: int, power: float, ambient: float, heat: float) -> None:
        """From `now` on there is a loss of `power` (W) in a surrounding of `ambient` (degC)."""
        end = ambient + self.resistance * power
        if end != self._end:
            self._start, self._end, self._since = self.at(now) - self._heat, end, now
        self._heat = heat

    def quiet(self, now: int) -> int:
        """Ticks until another whole degree is reached, or a little less."""
        present, end = self.at(now), self._end + self._heat
        whole = floor(present)
        falling = end < present
        boundary = whole if falling else whole + 1
        if not (end < boundary if falling else end > boundary):
            return NEVER
        seconds = self.time_constant * log((present - end) / (boundary - end))
        return max(1, floor(seconds / TICK))
