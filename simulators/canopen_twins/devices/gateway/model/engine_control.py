"""What a main cycle of the governor does with the engine. Assumed (A-47, A-55 to A-58)."""

from collections.abc import Callable, Mapping

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.engine import RATED_POWER, STANDSTILL, Engine
from canopen_twins.devices.gateway.model.inputs import Inputs
from canopen_twins.devices.gateway.model.parameters import Scaling
from canopen_twins.devices.gateway.model.speed_governor import (
    IDLE_SPEED,
    Condition,
    Mode,
    Operation,
    SpeedGovernor,
)

CLOSING_TIME = 1.0  # s above the closing speed
OPENING = 0.7  # of the closing speed, below which the generator breaker opens


class GeneratorBreaker:
    """Lets the consumers on to an engine that is fast enough, and takes them off one too slow."""

    def __init__(self, engine: Engine, operation: Operation, cycle: float) -> None:
        self._engine, self._operation, self._cycle = engine, operation, cycle
        self._fast = 0  # main cycles above the closing speed
        self.dropped = False
        """Whether it has opened in this main cycle because the engine was overloaded."""

    @property
    def is_steady(self) -> bool:
        """Whether it neither waits to close nor has just opened."""
        return (self._engine.connected or not self._fast) and not self.dropped

    def step(self, governor: SpeedGovernor, *, blocked: bool) -> None:
        """One main cycle; blocked: an error keeps it open."""
        engine, closing = self._engine, self._operation.breaker_speed
        self.dropped = False
        if governor.mode is not Mode.RUNNING or blocked:
            self._fast, engine.connected = 0, False
        elif engine.connected:
            if engine.speed < OPENING * closing:
                self._fast, engine.connected = 0, False
                self.dropped = governor.reference >= OPENING * closing
        elif engine.speed >= closing:
            self._fast += 1
            engine.connected = self._fast * self._cycle >= CLOSING_TIME
        else:
            self._fast = 0


ALARM_DELAY = 10.0  # s after the start, before which no alarm is looked at
LOW_OIL, LOWEST_OIL = 1.5, 1.0  # bar
HOT_AIR, HOTTEST_AIR = 85.0, 100.0  # degC


class Alarms:
    """Oil pressure and charge air of an engine that runs, looked at once a second."""

    def __init__(self, read: Callable[[], tuple[float, float]], cycle: float) -> None:
        """`read` tells the oil pressure in bar and the temperature of the charge air in degC."""
        self._read = read
        self._delay, self._period = round(ALARM_DELAY / cycle), max(1, round(1 / cycle))
        self._running = 0  # main cycles
        self.causes = 0
        """Bit k is error 3000+k."""

    @property
    def is_steady(self) -> bool:
        """Whether another look finds what the last has found; none is made without an engine."""
        return not self._running or self._running >= self._delay + self._period

    def leap(self, cycles: int) -> None:
        """So many main cycles in which nothing moves."""
        if self._running:
            self._running += cycles

    def step(self, *, running: bool) -> None:
        """One main cycle."""
        if not running:
            self._running = self.causes = 0
            return
        self._running += 1
        if self._running >= self._delay and self._running % self._period == 0:
            self.causes = self._found(*self._read())

    def _found(self, oil: float, air: float) -> int:
        found = 0
        if oil < LOW_OIL:
            found |= OIL_STOP if oil < LOWEST_OIL else OIL_WARNING
        if air > HOT_AIR:
            found |= AIR_STOP if air > HOTTEST_AIR else AIR_WARNING
        return found


OVERSPEED, UNDERSPEED = errors.bit(errors.OVERSPEED), errors.bit(errors.UNDERSPEED)
OIL_WARNING, OIL_STOP = errors.bit(errors.OIL_WARNING), errors.bit(errors.OIL_STOP)
AIR_WARNING, AIR_STOP = errors.bit(errors.AIR_WARNING), errors.bit(errors.AIR_STOP)
FAILURES = {
    Condition.GIVEN_UP: errors.bit(errors.START_FAILED),
    Condition.STALLED: errors.bit(errors.STALLED),
}
STOPPING = errors.bits(errors.STOPPING)
IDLE, SETPOINT_2_OR_1, LOAD_ENABLE = 811, 827, 835
EXTERNAL_SETPOINTS = (900, 901)
FULL_SETPOINT = 64000  # counts of an external setpoint
IDLE_BAND, SETPOINT_BAND = 20.0, 15.0  # rpm
OIL, AIR, CURRENT_LOAD = 905, 908, 917
MEASUREMENT = 2000  # sensor 900+s is shown as 2900+s


class EngineControl:
    """Acts on the engine as errors, switch functions and sensors allow and demand."""

    def __init__(
        self,
        engine: Engine,
        operation: Operation,
        inputs: Inputs,
        scaling: Scaling,
        governor: SpeedGovernor,
    ) -> None:
        self.engine = engine
        self._operation, self._inputs = operation, inputs
        self._scaling = scaling
        self.speed = governor
        self.at_rest = False
        """Whether all stays as it is, until somebody who knows says otherwise."""
        self._breaker = GeneratorBreaker(engine, operation, governor.cycle)
        self._alarms = Alarms(lambda: (self._oil, self._air), governor.cycle)

    @property
    def is_steady(self) -> bool:
        """Whether nothing is waited for that comes by itself."""
        return self.speed.is_steady and self._breaker.is_steady and self._alarms.is_steady

    def run_to(self, now: int) -> None:
        """Let the time up to `now`, in microseconds, pass for the engine."""
        if self.at_rest:
            self.engine.reached = now
        else:
            self.engine.run_to(now)

    def leap(self, cycles: int) -> None:
        """So many main cycles at rest."""
        self.speed.leap(cycles)
        self._alarms.leap(cycles)

    def step(self, present: int) -> None:
        """One main cycle; bit k of `present`: error 3000+k is reported."""
        if self.at_rest:
            self.leap(1)
            return
        governor = self.speed
        droop = 0.0 if self._inputs.active(LOAD_ENABLE) else self._operation.droop
        governor.step(self._target, droop, tripped=bool(present & STOPPING))
        self._breaker.step(governor, blocked=bool(present & UNDERSPEED))
        self._alarms.step(running=governor.mode is Mode.RUNNING)

    @property
    def causes(self) -> int:
        """What is wrong with the engine at this moment; bit k is error 3000+k."""
        causes = self._alarms.causes
        if self.engine.speed > self._operation.overspeed:
            causes |= OVERSPEED
        if self._breaker.dropped:
            causes |= UNDERSPEED
        if self.speed.failure is not None:
            causes |= FAILURES[self.speed.failure]
        return causes

    @property
    def _target(self) -> float:
        if self._inputs.active(IDLE):
            return IDLE_SPEED
        second = self._inputs.active(SETPOINT_2_OR_1)
        setpoint = self._inputs.value(EXTERNAL_SETPOINTS[second])
        if setpoint is None:
            return self._operation.local_setpoint
        full = self._operation.highest_speed - IDLE_SPEED
        return IDLE_SPEED + setpoint / FULL_SETPOINT * full

    def states(self, present: int) -> Mapping[str, bool]:
        """What the bits of 2000h:07 tell (A-33)."""
        speed, governor = self.engine.speed, self.speed
        running = governor.mode is Mode.RUNNING
        return {
            "stopped": speed < STANDSTILL,
            "cranking": governor.mode is Mode.CRANKING,
            "running": running,
            "idle": running and abs(speed - IDLE_SPEED) <= IDLE_BAND,
            "setpoint reached": running and abs(speed - governor.reference) <= SETPOINT_BAND,
            "running down": governor.mode is Mode.STOPPING,
            "load connected": self.engine.power > 0,
            "overspeed stop": bool(present & OVERSPEED),
        }

    @property
    def measurements(self) -> dict[int, Callable[[], float]]:
        """What the governor measures, in the units of the parameters."""
        engine = self.engine
        return {
            2000: lambda: engine.speed,
            2031: lambda: self.speed.setpoint,
            2300: lambda: 100 * engine.position,
            2330: lambda: 100 * engine.fuel,
            2905: lambda: self._oil,
            2908: lambda: self._air,
            2917: lambda: self._sensed(CURRENT_LOAD, 100 * engine.power / RATED_POWER),
        }

    @property
    def _oil(self) -> float:
        return self._sensed(OIL, self.engine.oil_pressure)

    @property
    def _air(self) -> float:
        return self._sensed(AIR, self.engine.charge_air)

    def _sensed(self, sensor: int, local: float) -> float:
        internal = self._inputs.value(sensor)
        if internal is None:
            return local
        return self._scaling.of(sensor + MEASUREMENT).external(internal)
