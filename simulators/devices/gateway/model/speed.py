"""Speed governor: start, setpoint ramp, PID and overspeed stop. All assumed (A-47)."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from simulators.devices.gateway.model.engine import RATED_POWER, Engine

RATED_SPEED = 1500.0  # rpm
IDLE_SPEED, HIGHEST_SPEED = 700.0, 1800.0  # rpm
OVERSPEED = 1725.0  # rpm
STANDSTILL = 10.0  # rpm
RELEASE_SPEED = 400.0  # rpm, at which the starter lets go
RAMP = 200.0  # rpm/s
START_FUEL = 0.3
IDLE_FUEL = 0.054  # what the integral begins with
GAIN, INTEGRAL_TIME, DERIVATIVE_TIME, DERIVATIVE_FILTER = 6.0, 0.7, 0.12, 0.03  # -, s, s, s


class Mode(Enum):
    """What the governor is doing with the engine."""

    STOPPED = "stopped"
    CRANKING = "cranking"
    RUNNING = "running"
    STOPPING = "running down"


class Event(Enum):
    """What makes it do something else."""

    START = "start is wanted and allowed"
    STOP = "start is not wanted, or overspeed"
    FIRED = "release speed reached"
    STILL = "standstill reached"


NEXT: Mapping[Mode, Mapping[Event, Mode]] = {
    Mode.STOPPED: {Event.START: Mode.CRANKING},
    Mode.CRANKING: {Event.FIRED: Mode.RUNNING, Event.STOP: Mode.STOPPING},
    Mode.RUNNING: {Event.STOP: Mode.STOPPING},
    Mode.STOPPING: {Event.STILL: Mode.STOPPED},
}


@dataclass
class Operation:
    """What the people at the engine have set; it outlives a reset of the governor."""

    run: bool = True
    """The start switch."""
    local_setpoint: float = RATED_SPEED
    """rpm, in force while no external setpoint is valid."""
    droop: float = 0.0
    """Fall of speed from no load to rated power, as a fraction of rated speed."""


class SpeedGovernor:
    """Acts on the engine once per main cycle; an engine that turns is taken over as it is."""

    def __init__(self, engine: Engine, operation: Operation, cycle: float) -> None:
        self._engine, self._operation, self._cycle = engine, operation, cycle
        self.mode = Mode.STOPPED
        self.setpoint = max(IDLE_SPEED, engine.speed)  # rpm
        self._integral = IDLE_FUEL
        self._derivative = 0.0
        self._deviation: float | None = None

    def step(self, target: float, *, tripped: bool) -> None:
        """One main cycle towards the target speed, rpm; tripped: overspeed was reported."""
        for event in self._events(tripped):
            self.mode = NEXT[self.mode].get(event, self.mode)
        engine = self._engine
        engine.starter = self.mode is Mode.CRANKING
        if self.mode is Mode.RUNNING:
            engine.fuel = self._govern(target)
        else:
            self.setpoint = IDLE_SPEED
            engine.fuel = START_FUEL if self.mode is Mode.CRANKING else 0.0

    def _events(self, tripped: bool) -> list[Event]:
        speed = self._engine.speed
        start = self._operation.run and not tripped
        events = [Event.START if start else Event.STOP]
        events += [Event.FIRED] * (speed >= RELEASE_SPEED) + [Event.STILL] * (speed < STANDSTILL)
        return events

    def _govern(self, target: float) -> float:
        step = RAMP * self._cycle
        target = min(max(IDLE_SPEED, target), HIGHEST_SPEED)
        self.setpoint += min(max(-step, target - self.setpoint), step)
        droop = self._operation.droop * RATED_SPEED * self._engine.power / RATED_POWER
        return self._pid((self.setpoint - droop - self._engine.speed) / RATED_SPEED)

    def _pid(self, deviation: float) -> float:
        before = deviation if self._deviation is None else self._deviation
        self._deviation = deviation
        slope = (deviation - before) / self._cycle
        self._derivative += (slope - self._derivative) * self._cycle / DERIVATIVE_FILTER
        wanted = GAIN * (deviation + DERIVATIVE_TIME * self._derivative) + self._integral
        fuel = min(max(0.0, wanted), 1.0)
        if fuel == wanted or (wanted > fuel) == (deviation < 0):  # anti-windup
            integral = self._integral + GAIN * deviation / INTEGRAL_TIME * self._cycle
            self._integral = min(max(0.0, integral), 1.0)
        return fuel
