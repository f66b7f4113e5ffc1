"""The charging stage: setpoints to output, sparks, and the pollution of its bar."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil

from canopen_twins.devices.charger.model.output import Demand, Output
from canopen_twins.devices.charger.model.parameters import Parameter, Parameters
from canopen_twins.devices.charger.model.pollution import (
    MONITORING,
    Calibration,
    Resistance,
    calibrating,
    pollution,
)
from canopen_twins.devices.charger.model.sparks import WINDOW, Sparks
from canopen_twins.devices.charger.model.storm import RandomSparks, Storm
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.devices.charger.model.ticks import NEVER, TICK
from canopen_twins.devices.charger.model.types import Quantity, Type

MICRO = 1e-6
ANALOG_INPUTS = (1, 2, 4, 5)  # 2002h:03h: 20 mA or 10 V
LIMIT_SIGNALS = (3, 4, 5)


@dataclass
class Charging:
    """Everything behind the charging terminal."""

    kind: Type
    parameters: Parameters
    sparks: Sparks
    output: Output = field(default_factory=Output, init=False)
    calibration: Calibration = field(default_factory=Calibration, init=False)
    _resistance: Resistance = field(default_factory=Resistance, init=False)
    _random: RandomSparks | None = field(default=None, init=False)

    @property
    def maximum_current(self) -> float:
        """Of the type, in A."""
        return self.kind.maximum_current * MICRO

    @property
    def analog(self) -> bool:
        """Whether the analog input gives the setpoint (2002h:03h)."""
        return self.parameters[Parameter.ANALOG_SETPOINT] in ANALOG_INPUTS

    @property
    def limit_signal(self) -> bool:
        """The digital output `Limit` (2002h:03h, A-63)."""
        reported = self.parameters[Parameter.ANALOG_SETPOINT] in LIMIT_SIGNALS
        return reported and self.output.limiter is not None

    @property
    def resistance(self) -> int:
        """Of the load, in ohm (2001h:0Ch)."""
        return self._resistance.value

    @property
    def pollution(self) -> int:
        """In % (6000h:05h)."""
        return pollution(self.parameters, self.resistance)

    @property
    def calibrating(self) -> bool:
        """Whether a calibration runs or waits for high voltage (2002h:19h)."""
        return calibrating(self.parameters)

    def setpoints(self, analog: float) -> Mapping[Quantity, int]:
        """In V and uA; `analog` is the level of the analog input in %, where it has its way."""
        values = self.parameters
        setpoints = {
            Quantity.VOLTAGE: values[Parameter.VOLTAGE_SETPOINT],
            Quantity.CURRENT: values[Parameter.CURRENT_SETPOINT],
        }
        if self.analog:
            setpoints[values.governing] = values.percent_of_maximum(analog)
        return setpoints

    def drive(self, now: int, ticks: int, surroundings: Surroundings, power: float) -> None:
        """Let `ticks` pass up to `now` with high voltage on, at `power` W at most."""
        load = surroundings.load(self.kind, self.parameters[Parameter.MODE])
        self.output.drive(now, ticks, self._demand(surroundings.analog, power), load)
        self._measure(now, ticks)
        self._expect_spark(now, self.output.voltage)

    def idle(self, now: int, ticks: int) -> None:
        """Let `ticks` pass up to `now` with high voltage off."""
        self.output.decay(ticks)
        self._resistance.clear()
        self._expect_spark(now, 0.0)

    def spark(self, now: int, current: float, rise_time: float) -> None:
        """The current jumps by so many A within so many s; counted unless a ramp runs."""
        duration = max(WINDOW, rise_time)
        if not self.output.ramping(now):
            self.sparks.see(now, current / duration, self.parameters, self.maximum_current)
        charge = current * duration
        self.output.flash_over(now, current, ceil(duration / TICK), charge / self.kind.capacitance)

    def expect(self, storm: Storm | None) -> None:
        """From now on sparks strike at random, or no more."""
        self._random = None if storm is None else RandomSparks(storm)

    def restart(self) -> None:
        """Counters and calibration start afresh (A-59)."""
        self.sparks.restart()
        self.calibration.restart()

    def quiet(self, now: int, on: bool) -> int:
        """Ticks until something happens by itself."""
        return min(
            self.output.quiet(now),
            self._resistance.quiet,
            self._random.quiet(now) if self._random else NEVER,
            self.calibration.quiet if on and self.calibrating else NEVER,
        )

    def _demand(self, analog: float, power: float) -> Demand:
        values, setpoints = self.parameters, self.setpoints(analog)
        return Demand(
            voltage=float(setpoints[Quantity.VOLTAGE]),
            current=setpoints[Quantity.CURRENT] * MICRO,
            power=power,
            governing=values.governing,
            ramp_time=values[Parameter.RAMP_TIME],
        )

    def _measure(self, now: int, ticks: int) -> None:
        voltage, current = round(self.output.voltage), round(self.output.current / MICRO)
        self._resistance.add(ticks, voltage, current)
        if not self.calibrating:
            return
        valid = not self.output.ramping(now)
        self.calibration.add(ticks, voltage if valid else 0, current if valid else 0)
        if self.calibration.done:
            result = self.calibration.result
            self.parameters.load(
                {Parameter.NOMINAL_RESISTOR: result, Parameter.POLLUTION_DETECTION: MONITORING}
            )

    def _expect_spark(self, now: int, voltage: float) -> None:
        if self._random is None:
            return
        self._random.lead(now, voltage)
        if self._random.due(now):
            self.spark(now, self._random.strike(now) * self.maximum_current, WINDOW)
