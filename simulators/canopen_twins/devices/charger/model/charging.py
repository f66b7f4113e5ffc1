"""The charging stage: setpoints to output, sparks, and the pollution of its bar."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil

from canopen_twins.devices.charger.model.output import Demand, Output
from canopen_twins.devices.charger.model.parameters import (
    CALIBRATING,
    MONITORING,
    OFF,
    Parameter,
    Parameters,
    half_up,
)
from canopen_twins.devices.charger.model.sparks import WINDOW, RandomSparks, Sparks, Storm
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.devices.charger.model.ticks import NEVER, TICK, TICK_MS, whole_ticks
from canopen_twins.devices.charger.model.types import Quantity, Type

MICRO = 1e-6
ANALOG_INPUTS = (1, 2, 4, 5)  # 2002h:03h: 20 mA or 10 V
MEAN_TIME = whole_ticks(1.0)  # the resistance is a mean over this time (assumed)
CALIBRATION = whole_ticks(20 * 60)  # 2002h:19h
NO_CURRENT = 0xFFFF_FFFF  # ohm


def resistance(voltage: int, current: int) -> int:
    """Whole ohm from sums of V and of uA; without current the largest value there is (A-51)."""
    return min(NO_CURRENT, half_up(voltage * 1_000_000, current)) if current else NO_CURRENT


@dataclass
class Resistance:
    """The resistance of the load over the last second; sums of whole V and uA are exact."""

    _samples: deque[tuple[int, int]] = field(default_factory=lambda: deque(maxlen=MEAN_TIME))
    _voltage: int = 0  # sums
    _current: int = 0
    _same: int = 0  # samples in a row without a difference

    @property
    def value(self) -> int:
        """Ohm; 0 with high voltage off (A-51)."""
        return resistance(self._voltage, self._current) if self._samples else 0

    def add(self, ticks: int, voltage: int, current: int) -> None:
        """Take the same sample `ticks` times over, in V and uA."""
        same = bool(self._samples) and self._samples[-1] == (voltage, current)
        if same and self._same >= MEAN_TIME:
            return
        self._same = (self._same if same else 0) + ticks
        for _ in range(min(ticks, MEAN_TIME)):
            if len(self._samples) == MEAN_TIME:
                self._voltage -= self._samples[0][0]
                self._current -= self._samples[0][1]
            self._samples.append((voltage, current))
            self._voltage += voltage
            self._current += current

    def clear(self) -> None:
        """High voltage is off."""
        self._samples.clear()
        self._voltage = self._current = self._same = 0

    @property
    def quiet(self) -> int:
        """Ticks until it changes."""
        return NEVER if self._same >= MEAN_TIME or not self._samples else 1


@dataclass
class Calibration:
    """Twenty minutes with high voltage on that give 2002h:1Ah (2002h:19h, A-60)."""

    _elapsed: int = 0  # ticks
    _voltage: int = 0  # sums of V and uA
    _current: int = 0

    def restart(self) -> None:
        """Forget what was collected."""
        self._elapsed = self._voltage = self._current = 0

    def add(self, ticks: int, voltage: int, current: int) -> None:
        """Time has passed with high voltage on; a ramp counts as time but gives no values."""
        self._elapsed += ticks
        self._voltage += ticks * voltage
        self._current += ticks * current

    @property
    def done(self) -> bool:
        """Whether the time is over."""
        return self._elapsed >= CALIBRATION

    @property
    def result(self) -> int:
        """The nominal resistance in ohm; never 0, which would mean none."""
        return max(1, resistance(self._voltage, self._current))

    @property
    def quiet(self) -> int:
        """Ticks of high voltage until it is done."""
        return CALIBRATION - self._elapsed


@dataclass
class Charging:
    """Everything behind the charging terminal."""

    kind: Type
    parameters: Parameters
    sparks: Sparks
    output: Output = field(init=False)
    calibration: Calibration = field(default_factory=Calibration, init=False)
    _resistance: Resistance = field(default_factory=Resistance, init=False)
    _random: RandomSparks | None = field(default=None, init=False)
    _around: Surroundings | None = field(default=None, init=False)  # none while it is off

    def __post_init__(self) -> None:
        self.output = Output(self.kind.capacitance)

    @property
    def maximum_current(self) -> float:
        """Of the type, in A."""
        return self.kind.maximum_current * MICRO

    @property
    def analog(self) -> bool:
        """Whether the analog input gives the setpoint (2002h:03h)."""
        return self.parameters[Parameter.ANALOG_SETPOINT] in ANALOG_INPUTS

    @property
    def resistance(self) -> int:
        """Of the load, in ohm (2001h:0Ch)."""
        return self._resistance.value

    @property
    def calibrating(self) -> bool:
        """Whether a calibration runs or waits: asked for, or because none has been (A-60)."""
        wanted = self.parameters[Parameter.POLLUTION_DETECTION]
        known = self.parameters[Parameter.NOMINAL_RESISTOR]
        return wanted == CALIBRATING or (wanted == MONITORING and not known)

    @property
    def pollution(self) -> int:
        """How far the resistance is from its nominal, in %, 100 at most (6000h:05h, A-61)."""
        nominal, present = self.parameters[Parameter.NOMINAL_RESISTOR], self.resistance
        off = self.parameters[Parameter.POLLUTION_DETECTION] == OFF
        if off or self.calibrating or not present:
            return 0
        return min(100, half_up(100 * abs(present - nominal), nominal))

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
        mode = self.parameters[Parameter.MODE]
        before = None
        if self._around is not None and self._around is not surroundings:
            before = self._around.load(self.kind, mode)
        self._around = surroundings
        demand, load = self._demand(surroundings.analog, power), surroundings.load(self.kind, mode)
        step = self.output.drive(now, ticks, demand, load, before)
        self._see(now * TICK_MS, step / WINDOW)
        self._measure(now, ticks)
        self._expect_spark(now, self.output.voltage)

    def idle(self, now: int, ticks: int, surroundings: Surroundings) -> None:
        """Let `ticks` pass up to `now` with high voltage off."""
        self._around = None
        if self.output.voltage:
            self.output.decay(ticks, surroundings.load(self.kind, self.parameters[Parameter.MODE]))
        else:
            self.output.hold(0.0)
        self._resistance.clear()
        self._expect_spark(now, 0.0)

    def spark(self, now: int, current: float, rise_time: float, late: int = 0) -> None:
        """The current jumps by so many A within so many s, `late` ms after a tick."""
        duration = max(WINDOW, rise_time)
        self._see(now * TICK_MS + late, current / duration)
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

    def _see(self, moment: int, steepness: float) -> None:
        self.sparks.see(moment, steepness, self.parameters, self.maximum_current)

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
