"""Speed governor: starts the engine, holds its speed, and takes its fuel away. Assumed (A-47)."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum
from operator import attrgetter

from canopen_twins.devices.gateway.model.engine import RATED_POWER, STANDSTILL, Engine

RATED_SPEED = 1500.0  # rpm
IDLE_SPEED = 700.0  # rpm
RELEASE_SPEED = 400.0  # rpm, at which the starter lets go
STALL_SPEED = 300.0  # rpm, below which a running engine does not come back
CRANK_TIME, REST_TIME, ATTEMPTS = 10.0, 5.0, 3  # s, s, - (A-57)
RAMP = 200.0  # rpm/s
START_FUEL = 0.3
IDLE_FUEL = 0.054  # what the integral begins with
GAIN, INTEGRAL_TIME, DERIVATIVE_TIME, DERIVATIVE_FILTER = 6.0, 0.7, 0.12, 0.03  # -, s, s, s


class Mode(Enum):
    """What the governor is doing with the engine."""

    STOPPED = "stopped"
    CRANKING = "cranking"
    RESTING = "between two attempts to start"
    RUNNING = "running"
    STOPPING = "running down"


class Condition(Enum):
    """What makes it do something else."""

    START = "start is wanted and allowed"
    STOP = "start is not wanted, or an error forbids it"
    TIME_OUT = "it was cranked for too long"
    GIVEN_UP = "the last attempt, too"
    RESTED = "the starter has cooled down"
    FIRED = "release speed reached"
    STALLED = "too slow to come back"
    STILL = "standstill reached"


NEXT: Mapping[Mode, Mapping[Condition, Mode]] = {
    Mode.STOPPED: {Condition.START: Mode.CRANKING},
    Mode.CRANKING: {
        Condition.FIRED: Mode.RUNNING,
        Condition.STOP: Mode.STOPPING,
        Condition.TIME_OUT: Mode.RESTING,
        Condition.GIVEN_UP: Mode.STOPPING,
    },
    Mode.RESTING: {Condition.RESTED: Mode.CRANKING, Condition.STOP: Mode.STOPPING},
    Mode.RUNNING: {Condition.STOP: Mode.STOPPING, Condition.STALLED: Mode.STOPPING},
    Mode.STOPPING: {Condition.STILL: Mode.STOPPED},
}


@dataclass
class Operation:
    """What the people at the engine have set; it outlives a reset of the governor."""

    run: bool = False
    """The start switch: the engine starts when it is turned on (A-53)."""
    autostart: bool = False
    """Whether a start switch that is on already is enough."""
    local_setpoint: float = RATED_SPEED
    """rpm, in force while no external setpoint is valid."""
    highest_speed: float = 1800.0
    """rpm, what no setpoint exceeds, and what an external one of 100 % means (A-56)."""
    overspeed: float = 2070.0
    """rpm, above which the engine is stopped (A-56)."""
    breaker_speed: float = 1425.0
    """rpm, at which the generator breaker closes (A-55)."""
    droop: float = 0.0
    """Fall of speed from no load to rated power, as a fraction of rated speed."""


class SpeedGovernor:
    """Acts on the engine once per main cycle."""

    def __init__(
        self, engine: Engine, operation: Operation, cycle: float, *, catches: bool = False
    ) -> None:
        """`catches`: an engine that turns is governed on, not left to run down (A-54)."""
        self._engine, self._operation, self.cycle = engine, operation, cycle
        caught = catches and engine.speed >= RELEASE_SPEED
        self.mode = Mode.STOPPED
        if engine.turning:
            self.mode = Mode.RUNNING if caught else Mode.STOPPING
        self.setpoint = max(IDLE_SPEED, engine.speed)
        """On its ramp, rpm."""
        self.reference = self.setpoint
        """What the ramp leads to, less the droop, rpm."""
        self.failure: Condition | None = None
        """GIVEN_UP or STALLED, in the main cycle in which it came to that."""
        self._armed = caught  # the switch was seen off, so that turning it on means something
        self._attempts = 0
        self._passed = 0  # main cycles in this mode
        self._integral = IDLE_FUEL
        self._derivative = 0.0
        self._deviation: float | None = None

    def step(self, target: float, droop: float, *, tripped: bool) -> None:
        """One main cycle towards the target speed, rpm; tripped: an error forbids to run."""
        self.failure = None
        self._passed += 1
        engine, wanted = self._engine, self._wanted(tripped)
        if not wanted or self.mode is not Mode.RUNNING or engine.speed < STALL_SPEED:
            for condition in self._conditions(wanted):
                self._meet(condition)
            engine.starter = self.mode is Mode.CRANKING
        if self.mode is Mode.RUNNING:
            engine.fuel = self._govern(target, droop)
        else:
            self.setpoint = IDLE_SPEED
            engine.fuel = START_FUEL if self.mode is Mode.CRANKING else 0.0

    @property
    def is_steady(self) -> bool:
        """Whether no time-out runs."""
        return self.mode in (Mode.STOPPED, Mode.RUNNING)

    def leap(self, cycles: int) -> None:
        """So many main cycles at rest."""
        self._passed += cycles

    def _meet(self, condition: Condition) -> None:
        before = self.mode
        self.mode = NEXT[before].get(condition, before)
        if self.mode is before:
            return
        self._passed = 0
        if before is Mode.STOPPED:
            self._attempts = 0
        if condition in (Condition.GIVEN_UP, Condition.STALLED):
            self.failure = condition

    def _conditions(self, wanted: bool) -> list[Condition]:
        speed, mode = self._engine.speed, self.mode
        met = [Condition.START if wanted else Condition.STOP]
        if speed >= RELEASE_SPEED:
            met.append(Condition.FIRED)
        elif mode is Mode.CRANKING and self._passed * self.cycle >= CRANK_TIME:
            self._attempts += 1
            last = self._attempts == ATTEMPTS
            met.append(Condition.GIVEN_UP if last else Condition.TIME_OUT)
        elif mode is Mode.RESTING and self._passed * self.cycle >= REST_TIME:
            met.append(Condition.RESTED)
        elif speed < STALL_SPEED:
            met.append(Condition.STALLED)
        if speed < STANDSTILL:
            met.append(Condition.STILL)
        return met

    def _wanted(self, tripped: bool) -> bool:
        operation = self._operation
        if tripped:
            self._armed = False
        elif operation.autostart or not operation.run:
            self._armed = True
        return operation.run and self._armed

    def _govern(self, target: float, droop: float) -> float:
        step = RAMP * self.cycle
        target = min(max(IDLE_SPEED, target), self._operation.highest_speed)
        self.setpoint += min(max(-step, target - self.setpoint), step)
        fall = droop * RATED_SPEED * self._engine.power / RATED_POWER
        self.reference = target - fall
        return self._pid((self.setpoint - fall - self._engine.speed) / RATED_SPEED)

    def _pid(self, deviation: float) -> float:
        before = deviation if self._deviation is None else self._deviation
        self._deviation = deviation
        slope = (deviation - before) / self.cycle
        self._derivative += (slope - self._derivative) * self.cycle / DERIVATIVE_FILTER
        wanted = GAIN * (deviation + DERIVATIVE_TIME * self._derivative) + self._integral
        fuel = min(max(0.0, wanted), 1.0)
        if fuel == wanted or (wanted > fuel) == (deviation < 0):  # anti-windup
            integral = self._integral + GAIN * deviation / INTEGRAL_TIME * self.cycle
            self._integral = min(max(0.0, integral), 1.0)
        return fuel


HELD = attrgetter("mode", "failure", "_armed")
"""What a governor is about."""
MOTION = attrgetter("setpoint", "reference", "_integral", "_derivative", "_deviation")
"""What moves in one."""
OPERATION = attrgetter(*(field.name for field in fields(Operation)))
