"""The charging output: regulators, the ramp of every set value, and the charge it carries."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import exp
from typing import NamedTuple, Protocol

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


class Fed(Protocol):
    """What takes more current, and more power, the higher the voltage."""

    def current(self, voltage: float) -> float:
        """A, at a voltage in V."""
        ...

    def power(self, voltage: float) -> float:
        """W, at a voltage in V."""
        ...


def regulate(demand: Demand, load: Fed) -> tuple[float, Quantity]:
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
SETTLED = 0.5  # V
AT_ITS_LIMIT = 0.99  # of a set value: the quantity that limits stands there (assumed)


class Held(NamedTuple):
    """A load beside its capacitance, which stands at `start` and is charged within `time`."""

    load: Load
    capacitance: float  # F
    start: float  # V
    time: float  # s

    def current(self, voltage: float) -> float:
        """A, that get the voltage (V) there; negative where it has to fall by itself."""
        return self.load.current(voltage) + self.capacitance * (voltage - self.start) / self.time

    def power(self, voltage: float) -> float:
        """W."""
        return voltage * self.current(voltage)

    @property
    def drained(self) -> float:
        """V, to which it falls if nothing is fed: the output sinks no current."""
        return self.start * exp(-self.time * self.load.decay_rate(self.capacitance))


class Point(NamedTuple):
    """Where the output stands, and what holds it there; none: the ramp."""

    voltage: float = 0.0  # V
    current: float = 0.0  # A
    regulator: Quantity | None = None


@dataclass
class Output:
    """Voltage and current at the charging terminal; all time constants are assumed."""

    capacitance: float  # F, of cable and bar
    voltage: float = field(default=0.0, init=False)  # V
    current: float = field(default=0.0, init=False)  # A
    regulator: Quantity | None = field(default=None, init=False)
    _demand: Demand | None = field(default=None, init=False)  # the last one; none while off
    _ramp: Ramp | None = field(default=None, init=False)  # from 0 to 1
    _start: Point = field(default=Point(), init=False)  # where the ramp began
    _now: Point = field(default=Point(), init=False)  # without sparks
    _flash: float = field(default=0.0, init=False)  # A, on top of the load
    _flash_end: int = field(default=0, init=False)  # tick

    @property
    def power(self) -> float:
        """W."""
        return self.voltage * self.current

    @property
    def limiter(self) -> Quantity | None:
        """The regulator that has its way instead of the one of the mode (A-54)."""
        if self._demand is None or self.regulator is self._demand.governing:
            return None
        return self.regulator

    def ramping(self, now: int) -> bool:
        """Whether a ramp runs, or is about to."""
        return self._ramp is None or not self._ramp.done(now)

    def quiet(self, now: int) -> int:
        """Ticks until something changes that has not begun to change yet."""
        if self._ramp is not None and not self._ramp.done(now):
            return 1
        return self._flash_end - now if self._flash_end > now else NEVER

    def drive(
        self, now: int, ticks: int, demand: Demand, load: Load, before: Load | None = None
    ) -> float:
        """Let `ticks` pass up to `now` with high voltage on.

        `before` is the load until now if it is another. Returns by how much (A) the current has
        jumped with it; what a ramp or a set value makes of the current is no part of that.
        """
        self._follow(now - ticks, demand, load)
        step = 0.0
        point = self._operate(now, ticks, demand, load)
        if before is not None and before != load:
            step = point.current - self._operate(now, ticks, demand, before).current
        disturbance = self.voltage - self._now.voltage
        disturbance *= exp(-ticks * TICK / SETTLING_TIME)
        self._now, self.regulator = point, point.regulator
        self.voltage = point.voltage + (disturbance if abs(disturbance) > SETTLED else 0.0)
        self.current = point.current
        if self.voltage != point.voltage:
            less = load.current(point.voltage) - load.current(self.voltage)
            self.current = max(0.0, point.current - less)
        if now < self._flash_end:
            self.current += self._flash
        return step

    def decay(self, ticks: int, load: Load) -> None:
        """Let `ticks` pass with high voltage off, or without supply: the load drains the charge."""
        left = Held(load, self.capacitance, self.voltage, ticks * TICK).drained
        self.hold(left if left > SETTLED else 0.0)

    def hold(self, voltage: float) -> None:
        """So many V are left, and nothing is fed."""
        self._ramp = self._demand = self.regulator = None
        self.voltage, self.current = voltage, 0.0
        self._now = Point(voltage)

    def flash_over(self, now: int, current: float, duration: int, voltage: float) -> None:
        """A spark takes `current` (A) for `duration` ticks and pulls the voltage down by some V."""
        self.current += current
        self.voltage = max(0.0, self.voltage - voltage)
        self._flash, self._flash_end = current, now + duration

    def _follow(self, begin: int, demand: Demand, load: Load) -> None:
        """Begin a ramp at switch-on, and where a changed set value moves the output (2002h:11h)."""
        last, self._demand = self._demand, demand
        if last is not None and not _moves(last, demand, load):
            return
        self._start = Point() if last is None else self._now
        self._ramp = Ramp(0.0, 1.0, begin, demand.ramp_time)

    def _operate(self, now: int, ticks: int, demand: Demand, load: Load) -> Point:
        """Where regulators and ramp take the output with a load."""
        assert self._ramp is not None
        share, end, regulator = self._ramp.at(now), *regulate(demand, load)
        if share == 1 and abs(self._now.voltage - end) <= SETTLED:  # most of the time
            return Point(end, load.current(end), regulator)
        allowed = demand if share == 1 else self._on_the_way(share, demand, end, regulator)
        held = Held(load, self.capacitance, self._now.voltage, ticks * TICK)
        voltage = max(regulate(allowed, held)[0], held.drained)
        if share == 1 and abs(voltage - end) <= SETTLED:
            return Point(end, load.current(end), regulator)
        current = max(0.0, min(held.current(voltage), allowed.current))
        if share == 1 or self._start.regulator is regulator:
            return Point(voltage, current, regulator)
        standing = {
            Quantity.VOLTAGE: voltage >= AT_ITS_LIMIT * demand.voltage,
            Quantity.CURRENT: load.current(voltage) >= AT_ITS_LIMIT * demand.current,
            Quantity.POWER: load.power(voltage) >= AT_ITS_LIMIT * demand.power,
        }
        return Point(voltage, current, regulator if standing[regulator] else None)

    def _on_the_way(self, share: float, demand: Demand, end: float, regulator: Quantity) -> Demand:
        """What the ramp allows: the voltage rises evenly to its end, in I-Const the current."""
        start = self._start
        if regulator is demand.governing is Quantity.CURRENT:
            end, current = demand.voltage, start.current + share * (demand.current - start.current)
        else:
            above = max(0.0, start.current - demand.current)
            current = demand.current + (1 - share) * above
        voltage = start.voltage + share * (end - start.voltage)
        return demand._replace(voltage=voltage, current=current)


def _moves(last: Demand, demand: Demand, load: Load) -> bool:
    """Whether set values have changed so that the output ends elsewhere."""
    if last[:2] == demand[:2] and last.governing is demand.governing:
        return False
    before = last._replace(power=demand.power)
    return regulate(before, load)[0] != regulate(demand, load)[0]
