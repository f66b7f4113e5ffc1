"""Engine with actuator, oil and charge air, and what governs its speed. All assumed (A-47)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from math import copysign, exp, pi

from canopen_twins.devices.gateway.model.inputs import Inputs
from canopen_twins.devices.gateway.model.parameters import Scaling

RADIANS = pi / 30  # rad/s per rpm
SUBSTEP = 0.003125  # s, a fifth of the governor's main cycle

INERTIA = 10.0  # kg m2
FULL_TORQUE = 1900.0  # N m
COMBUSTION_SPEED = 60.0  # rpm, below which no charge ignites
STARTER_TORQUE = 600.0  # N m, at standstill
STARTER_SPEED = 270.0  # rpm, at which it pulls no more
GENERATOR_EFFICIENCY = 0.95
ACTUATOR_LAG, ACTUATOR_RATE = 0.04, 4.0  # s, 1/s
COMBUSTION_LAG = 0.06  # s
OIL_LAG, AIR_LAG = 1.0, 8.0  # s
OIL_SPEED = 50.0  # rpm, below which the pump builds up nothing
AMBIENT = 25.0  # degC
RATED_POWER = 200_000.0  # W


@dataclass
class Engine:
    """A genset: `run_to` brings it to the present with the inputs as they were meanwhile."""

    load: float = 0.0
    """What the consumers want, W."""
    load_connected: bool = False
    starter: bool = False
    fuel: float = 0.0
    """Actuator command, 0..1."""
    speed: float = 0.0
    """rpm"""
    position: float = 0.0
    """Of the actuator, 0..1."""
    combustion: float = 0.0
    """What burns of the full quantity, 0..1."""
    oil_pressure: float = 0.0
    """bar"""
    charge_air: float = AMBIENT
    """degC"""
    _reached: int = 0

    @property
    def power(self) -> float:
        """What the generator delivers, W."""
        return self.load if self.load_connected else 0.0

    def run_to(self, now: int) -> None:
        """Let the time up to `now`, in microseconds, pass."""
        seconds = (now - self._reached) / 1_000_000
        self._reached = now
        substeps = max(1, round(seconds / SUBSTEP))
        for _ in range(substeps):
            self._move(seconds / substeps)
            if self.speed == self.fuel == 0 and not self.starter and self.position < 1e-9:
                break  # the rest of the time changes nothing
        self._settle(seconds)

    def _move(self, dt: float) -> None:
        position, combustion, speed = self.position, self.combustion, self.speed
        rate = (self.fuel - position) / ACTUATOR_LAG
        if abs(rate) > ACTUATOR_RATE:
            rate = copysign(ACTUATOR_RATE, rate)
        position += rate * dt
        combustion += (position - combustion) / COMBUSTION_LAG * dt
        speed += self._torque(speed, combustion) / INERTIA / RADIANS * dt
        self.position, self.combustion, self.speed = position, combustion, max(0.0, speed)

    def _torque(self, speed: float, combustion: float) -> float:
        driving = FULL_TORQUE * combustion if speed > COMBUSTION_SPEED else 0.0
        if self.starter:
            driving += max(0.0, STARTER_TORQUE * (1 - speed / STARTER_SPEED))
        driving -= 60 + 0.06 * speed  # friction
        if not self.load_connected:
            return driving
        return driving - self.load / (GENERATOR_EFFICIENCY * max(1.0, speed * RADIANS))

    def _settle(self, seconds: float) -> None:
        pressure = 2.5 + 2 * (self.speed - 700) / 800 if self.speed >= OIL_SPEED else 0.0
        self.oil_pressure += (pressure - self.oil_pressure) * (1 - exp(-seconds / OIL_LAG))
        air = AMBIENT + 40 * self.power / RATED_POWER
        self.charge_air += (air - self.charge_air) * (1 - exp(-seconds / AIR_LAG))


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


class Condition(Enum):
    """What makes it do something else."""

    START = "start is wanted and allowed"
    STOP = "start is not wanted, or overspeed"
    FIRED = "release speed reached"
    STILL = "standstill reached"


NEXT: Mapping[Mode, Mapping[Condition, Mode]] = {
    Mode.STOPPED: {Condition.START: Mode.CRANKING},
    Mode.CRANKING: {Condition.FIRED: Mode.RUNNING, Condition.STOP: Mode.STOPPING},
    Mode.RUNNING: {Condition.STOP: Mode.STOPPING},
    Mode.STOPPING: {Condition.STILL: Mode.STOPPED},
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
        for condition in self._conditions(tripped):
            self.mode = NEXT[self.mode].get(condition, self.mode)
        engine = self._engine
        engine.starter = self.mode is Mode.CRANKING
        if self.mode is Mode.RUNNING:
            engine.fuel = self._govern(target)
        else:
            self.setpoint = IDLE_SPEED
            engine.fuel = START_FUEL if self.mode is Mode.CRANKING else 0.0

    def _conditions(self, tripped: bool) -> list[Condition]:
        speed = self._engine.speed
        met = [Condition.START if self._operation.run and not tripped else Condition.STOP]
        if speed >= RELEASE_SPEED:
            met.append(Condition.FIRED)
        if speed < STANDSTILL:
            met.append(Condition.STILL)
        return met

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


IDLE, SETPOINT_2_OR_1, LOAD_ENABLE = 811, 827, 835
EXTERNAL_SETPOINTS = (900, 901)
FULL_SETPOINT = 64000  # counts of an external setpoint
IDLE_BAND, SETPOINT_BAND = 20.0, 15.0  # rpm
MEASUREMENT = 2000  # sensor 900+s is shown as 2900+s


class EngineControl:
    """Everything of a main cycle that has to do with the engine. Assumed (A-47)."""

    def __init__(
        self,
        engine: Engine,
        operation: Operation,
        inputs: Inputs,
        scaling: Scaling,
        cycle: float,
    ) -> None:
        self._engine, self._operation, self._inputs = engine, operation, inputs
        self._scaling = scaling
        self.speed = SpeedGovernor(engine, operation, cycle)

    def step(self, *, tripped: bool) -> None:
        """One main cycle; tripped: overspeed was reported."""
        unassigned = LOAD_ENABLE not in self._inputs.functions
        self._engine.load_connected = unassigned or self._inputs.active(LOAD_ENABLE)
        self.speed.step(self._target, tripped=tripped)

    def end(self) -> None:
        """The governor is reset or off: actuator, starter and load fall off."""
        self._engine.fuel, self._engine.starter, self._engine.load_connected = 0.0, False, False

    @property
    def overspeed(self) -> bool:
        """Whether the engine is too fast at this moment."""
        return self._engine.speed > OVERSPEED

    @property
    def _target(self) -> float:
        if self._inputs.active(IDLE):
            return IDLE_SPEED
        second = self._inputs.active(SETPOINT_2_OR_1)
        setpoint = self._inputs.value(EXTERNAL_SETPOINTS[second])
        if setpoint is None:
            return self._operation.local_setpoint
        return IDLE_SPEED + setpoint / FULL_SETPOINT * (HIGHEST_SPEED - IDLE_SPEED)

    def states(self, *, tripped: bool) -> Mapping[str, bool]:
        """What the bits of 2000h:07 tell (A-33)."""
        speed, mode = self._engine.speed, self.speed.mode
        running = mode is Mode.RUNNING
        return {
            "stopped": speed < STANDSTILL,
            "cranking": mode is Mode.CRANKING,
            "running": running,
            "idle": running and abs(speed - IDLE_SPEED) <= IDLE_BAND,
            "setpoint reached": running and abs(speed - self.speed.setpoint) <= SETPOINT_BAND,
            "running down": mode is Mode.STOPPING,
            "load connected": self._engine.power > 0,
            "overspeed stop": tripped,
        }

    @property
    def measurements(self) -> dict[int, Callable[[], float]]:
        """What the governor measures, in the units of the parameters."""
        engine = self._engine
        return {
            2000: lambda: engine.speed,
            2031: lambda: self.speed.setpoint,
            2300: lambda: 100 * engine.position,
            2330: lambda: 100 * engine.fuel,
            2905: lambda: self._sensed(905, engine.oil_pressure),
            2908: lambda: self._sensed(908, engine.charge_air),
            2917: lambda: self._sensed(917, 100 * engine.power / RATED_POWER),
        }

    def _sensed(self, sensor: int, local: float) -> float:
        internal = self._inputs.value(sensor)
        if internal is None:
            return local
        return self._scaling.of(sensor + MEASUREMENT).external(internal)
