"""Everything about an output stage that is set from outside, at any time, by plain assignment."""

from dataclasses import KW_ONLY, dataclass, field
from math import expm1, inf, log
from random import Random
from typing import ClassVar

from canopen_twins.devices.topcon.model.circuit import Circuit, Law
from canopen_twins.devices.topcon.model.loads import Load, Open
from canopen_twins.devices.topcon.model.modes import Mode, State
from canopen_twins.devices.topcon.model.unit import FULL_SCALE, Connection, UnitType

LEVEL_MARGIN = 1.1  # protection levels at power-on, as parts: 4400


@dataclass(eq=False)
class Inputs:
    """Set values and surroundings, in V, A, W, ohm, s, Hz and degC.

    `unit` is one unit when it comes in and the figures of the whole system of `units` after that.
    """

    unit: UnitType
    _: KW_ONLY
    load: Load = field(default_factory=Open)
    ambient: float = 25.0
    units: int = 1  # fixed from here to `seed` once the stage is powered
    connection: Connection = "parallel"
    boot_time: float = 0.0
    overvoltage_when_off: bool = True
    noise: float = 0.0  # parts up and down in every reading
    seed: int = 0

    voltage_reference: float = 0.0  # A-42, as the next ones
    current_reference: float = 0.0
    power_reference: float = field(init=False)
    resistance_reference: float = 0.0
    overvoltage_level: float = field(init=False)
    overcurrent_level: float = field(init=False)
    overvoltage_warning: float = inf  # off by default
    overcurrent_warning: float = inf

    mains: float = 400.0  # V between lines
    mains_frequency: float = 50.0
    supply_24v: float = 24.0
    supply_5v: float = 5.0
    supply_15v: float = 15.0
    supply_minus_15v: float = -15.0
    interlock_closed: bool = True
    slave_silent: bool = False  # a unit of the system does not answer the master
    sense_offset: float = 0.0  # V at the sense lines that are not at the terminals
    sense_reversed: bool = False

    def __post_init__(self) -> None:
        self.unit = self.unit.system(self.units, self.connection)
        self.power_reference = self.unit.nominal_power
        self.overvoltage_level = LEVEL_MARGIN * self.unit.nominal_voltage
        self.overcurrent_level = LEVEL_MARGIN * self.unit.maximum_current


SLOPE_1 = 1.6  # s from zero to full scale at slope 1, by Regatron's DLL header


class Ramps:
    """Ramped set values in V and A. Power and resistance act at once, without a ramp."""

    def __init__(self, unit: UnitType) -> None:
        self._unit = unit
        self.restart()

    def restart(self) -> None:
        """Forget the set values reached; the start slope holds until both are reached again."""
        self.voltage = self.current = 0.0
        self._slope = self._unit.start_slope

    def reached(self, voltage: float, current: float) -> bool:
        """Whether nothing is left to ramp, once these are the set values."""
        return self.voltage == voltage and self.current == current

    def step(self, dt: float, voltage: float, current: float) -> None:
        """Approach the set values for `dt` seconds."""
        part = dt * self._slope / SLOPE_1
        self.voltage = _toward(voltage, self.voltage, part * self._unit.nominal_voltage)
        self.current = _toward(current, self.current, part * self._unit.maximum_current)
        if self.reached(voltage, current):
            self._slope = self._unit.run_slope


def _toward(target: float, value: float, reach: float) -> float:
    if target > value:
        return min(target, value + reach)
    return max(target, value - reach)


WARM = 80.0  # degC: warning, and the current limit begins to fall (assumed)
HOT = 95.0  # degC: trip (assumed)
LEAST = 0.5  # of the maximum current, at HOT (assumed)


class HeatSink:
    """Temperature in degC; losses in W warm it above the ambient."""

    def __init__(self, unit: UnitType, temperature: float) -> None:
        self._unit = unit
        self.temperature = temperature

    @property
    def time_constant(self) -> float:
        """Seconds."""
        return self._unit.thermal_resistance * self._unit.thermal_capacity

    @property
    def derating(self) -> float:
        """Part of the maximum current it can carry: 1 when not warm, 0.5 and no less when hot."""
        excess = (self.temperature - WARM) / (HOT - WARM)
        return 1.0 - (1.0 - LEAST) * min(max(excess, 0.0), 1.0)

    def step(self, dt: float, loss: float, ambient: float) -> None:
        """`dt` seconds, of any length, at constant loss."""
        way = self.end(loss, ambient) - self.temperature
        self.temperature -= way * expm1(-dt / self.time_constant)

    def end(self, loss: float, ambient: float) -> float:
        """The temperature that `loss` leads to."""
        return ambient + loss * self._unit.thermal_resistance

    def time_to(self, level: float, end: float) -> float:
        """Seconds until the temperature rises to `level` on its way to `end`; inf if never."""
        if not self.temperature < level < end:
            return inf
        return self.time_constant * log((end - self.temperature) / (end - level))


def derated_at(part: float) -> float:
    """The temperature at which only `part` of the maximum current is left; WARM at least."""
    return WARM + max(0.0, 1.0 - part) / (1.0 - LEAST) * (HOT - WARM)


HAIR = 1e-9  # a current of exactly the permitted one, but for its last bit, fills nothing


class I2tStore:
    """Charge in A2s, never below 0; the unit warns at half its limit and trips at the limit."""

    def __init__(self, unit: UnitType) -> None:
        self._unit = unit
        self.charge = 0.0

    def step(self, dt: float, current: float) -> None:
        """`dt` seconds, of any length, at constant current."""
        self.charge = max(0.0, self.charge + self._rate(current) * dt)

    def time_to(self, level: float, current: float) -> float:
        """Seconds until the charge rises to `level`; inf if never."""
        rate = self._rate(current)
        if rate <= 0.0 or self.charge >= level:
            return inf
        return (level - self.charge) / rate

    def _rate(self, current: float) -> float:
        permitted = self._unit.i2t_current**2
        rate = current**2 - permitted
        return rate if abs(rate) > HAIR * permitted else 0.0


@dataclass(eq=False)
class Plant(Inputs):
    """The power side of an output stage."""

    tick: ClassVar[float] = 0.001  # s

    state: State = field(default=State.POWERUP, init=False)
    ticks: int = field(default=0, init=False)  # since power-on

    def __post_init__(self) -> None:
        super().__post_init__()
        self.ramps = Ramps(self.unit)
        self.circuit = Circuit(self.unit)
        self.heat = HeatSink(self.unit, self.ambient)
        self.store = I2tStore(self.unit)
        self.mains_before = self.mains

    @property
    def running(self) -> bool:
        """Whether the output is on."""
        return self.state is State.RUN or self.state is State.WARN

    @property
    def mode(self) -> Mode:
        """The limit that holds the output."""
        return self.circuit.mode if self.running else Mode.OFF

    @property
    def voltage(self) -> float:
        """V at the terminals, as measured (7.3.10)."""
        return self.circuit.voltage + self._noise("voltage") * self.unit.nominal_voltage

    @property
    def current(self) -> float:
        """A into the load, as measured (7.3.11)."""
        return self.circuit.current + self._noise("current") * self.unit.maximum_current

    @property
    def power(self) -> float:
        """W, from the two before any rounding (7.3.12)."""
        return self.voltage * self.current

    @property
    def temperature(self) -> float:
        """Of the heat sink, degC."""
        return self.heat.temperature

    @property
    def i2t(self) -> float:
        """In the I2t store, A2s."""
        return self.store.charge

    @property
    def loss(self) -> float:
        """W into the heat sink; current taken in costs as much as current given out."""
        if not self.running:
            return 0.0
        power = abs(self.circuit.voltage * self.circuit.current)
        return power * (1.0 / self.unit.efficiency - 1.0) + self.unit.idle_power

    @property
    def derated_maximum(self) -> float:
        """A that the heat sink allows now."""
        return self.heat.derating * self.unit.maximum_current

    def flow(self, ticks: int) -> None:
        """Let `ticks` pass, as one step of the circuit."""
        law = self._law(ticks * self.tick) if self.running else None
        self.circuit.step(ticks * self.tick, law, self.load)
        self.coast(ticks)

    def coast(self, ticks: int) -> None:
        """Let `ticks` pass, any number, in which voltage and current stay as they are."""
        self.heat.step(ticks * self.tick, self.loss, self.ambient)
        self.store.step(ticks * self.tick, self.circuit.current)
        self.ticks += ticks

    def _law(self, dt: float) -> Law:
        self.ramps.step(dt, self.voltage_reference, self.current_reference)
        return Law(
            self.ramps.voltage,
            max(self.resistance_reference, self.unit.droop),
            min(self.ramps.current, self.derated_maximum),
            self.power_reference,
            self.unit.sink_current,
        )

    def _noise(self, channel: str) -> float:
        """Of full scale; drawn from the time, so that reading twice reads the same."""
        if not self.noise:
            return 0.0
        draw = Random(f"{self.seed} {channel} {self.ticks}").uniform(-1.0, 1.0)
        return draw * self.noise / FULL_SCALE
