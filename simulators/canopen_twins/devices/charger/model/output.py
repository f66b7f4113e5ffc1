"""The ramp of the charging: every setpoint is reached after the same time, whatever the step."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import exp
from typing import NamedTuple

from canopen_twins.devices.charger.model.load import Load
from canopen_twins.devices.charger.model.ticks import NEVER, TICK, TICK_MS
from canopen_twins.devices.charger.model.types import Quantity


class Ramp(NamedTuple):
    """A straight line from one reference to another (2002h:11h)."""

    start: float
    end: float
    begin: int  # tick
    time: int  # ms

    def at(self, now: int) -> float:
        """The reference at a tick."""
        if self.done(now):
            return self.end
        return self.start + (self.end - self.start) * (now - self.begin) * TICK_MS / self.time

    def done(self, now: int) -> bool:
        """Whether the end is reached."""
        return (now - self.begin) * TICK_MS >= self.time


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


SETTLING_TIME = 0.02  # s, time constant with which a disturbance dies away
DISCHARGE_TIME = 0.1  # s, time constant of the voltage once it is off
SETTLED = 0.5  # V


@dataclass
class Output:
    """Voltage and current at the charging terminal; all time constants are assumed."""

    voltage: float = field(default=0.0, init=False)  # V
    current: float = field(default=0.0, init=False)  # A
    regulator: Quantity | None = field(default=None, init=False)
    _governing: Quantity | None = field(default=None, init=False)
    _ramp: Ramp | None = field(default=None, init=False)
    _command: float = field(default=0.0, init=False)  # V, what the regulators want
    _flash: float = field(default=0.0, init=False)  # A, on top of the load
    _flash_end: int = field(default=0, init=False)  # tick

    @property
    def power(self) -> float:
        """W."""
        return self.voltage * self.current

    @property
    def limiter(self) -> Quantity | None:
        """The regulator that has its way instead of the one of the mode (A-54)."""
        return self.regulator if self.regulator is not self._governing else None

    def ramping(self, now: int) -> bool:
        """Whether a ramp runs, or is about to."""
        return self._ramp is None or not self._ramp.done(now)

    def quiet(self, now: int) -> int:
        """Ticks until something changes that has not begun to change yet."""
        if self._ramp is not None and not self._ramp.done(now):
            return 1
        return self._flash_end - now if self._flash_end > now else NEVER

    def drive(self, now: int, ticks: int, demand: Demand, load: Load) -> None:
        """Let `ticks` pass up to `now` with high voltage on."""
        self._ramp = self._follow(now - ticks, demand)
        disturbance = self.voltage - self._command
        reference = demand.at(self._ramp.at(now))
        self._command, self.regulator = regulate(reference, load)
        disturbance *= exp(-ticks * TICK / SETTLING_TIME)
        self.voltage = self._command + (disturbance if abs(disturbance) > SETTLED else 0.0)
        self.current = load.current(self.voltage) + (self._flash if now < self._flash_end else 0.0)

    def decay(self, ticks: int) -> None:
        """Let `ticks` pass with high voltage off."""
        self._ramp = self._governing = self.regulator = None
        self._command = self.current = 0.0
        self.voltage *= exp(-ticks * TICK / DISCHARGE_TIME)
        if self.voltage < SETTLED:
            self.voltage = 0.0

    def flash_over(self, now: int, current: float, duration: int, voltage: float) -> None:
        """A spark takes `current` (A) for `duration` ticks and pulls the voltage down by some V."""
        self.current += current
        self.voltage = max(0.0, self.voltage - voltage)
        self._flash, self._flash_end = current, now + duration

    def _follow(self, begin: int, demand: Demand) -> Ramp:
        """The ramp under way, or a new one if something else is demanded now."""
        if self._ramp is None:
            start = 0.0
        elif demand.governing is not self._governing:
            start = self.current if demand.governing is Quantity.CURRENT else self.voltage
        elif demand.target == self._ramp.end:
            return self._ramp
        else:
            start = self._ramp.at(begin)
        self._governing = demand.governing
        return Ramp(start, demand.target, begin, demand.ramp_time)
