"""Governor at its engine: which setpoint holds, whether load is let on, and what is measured."""

from collections.abc import Callable, Mapping

from simulators.devices.gateway.model.engine import RATED_POWER, Engine
from simulators.devices.gateway.model.inputs import Inputs
from simulators.devices.gateway.model.scaling import Scaling
from simulators.devices.gateway.model.speed import (
    HIGHEST_SPEED,
    IDLE_SPEED,
    OVERSPEED,
    STANDSTILL,
    Mode,
    Operation,
    SpeedGovernor,
)

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
        return self._scaling.external(sensor + MEASUREMENT, internal)
