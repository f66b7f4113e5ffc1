"""The power side of an output stage: what is set from outside, and how it moves in time."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from math import copysign, inf
from typing import ClassVar

from canopen_twins.devices.topcon.model.circuit import Circuit, Law, Ramps
from canopen_twins.devices.topcon.model.loads import Load, Open
from canopen_twins.devices.topcon.model.states import Mode, StageState
from canopen_twins.devices.topcon.model.thermal import HOT, WARM, HeatSink, I2tStore, derated_at
from canopen_twins.devices.topcon.model.unit import Connection, UnitType

LEVEL_MARGIN = 1.1  # protection levels at power-on, as parts: 4400
TOUCH = 1.001  # the derated maximum bends the output from this much above the current on
EVEN = 1e-4  # K: so near its end, the temperature moves the output by 0.01 parts at most
SLOW = 1e-3  # of full scale a step: heat moves the output no faster
CREEP = 0.01  # s in one go while it does
ON = (StageState.RUN, StageState.WARN)


@dataclass(eq=False)
class Inputs:
    """Set values and surroundings, in V, A, W, ohm, s, Hz and degC; assigned at any time.

    `unit` is one unit when it comes in and the figures of the whole system of `units` after that.
    """

    unit: UnitType
    _: KW_ONLY
    load: Load = field(default_factory=Open)
    ambient: float = 25.0
    units: int = 1  # fixed from here to `overvoltage_when_off` once the stage is powered
    connection: Connection = "parallel"
    boot_time: float = 0.0
    cooldown: float = 10.0  # K below its limit until an overtemperature is over
    overvoltage_when_off: bool = True

    voltage_reference: float = 0.0  # A-42, as the next ones
    current_reference: float = 0.0
    power_reference: float = field(init=False)
    resistance_reference: float = 0.0
    overvoltage_level: float = field(init=False)
    overcurrent_level: float = field(init=False)
    overvoltage_warning: float = inf  # off by default
    overcurrent_warning: float = inf

    mains: float = 400.0  # V between lines
    mains_goal: float = 400.0  # V, where they are going
    mains_slew: float = 0.0  # V/s on that way; 0: they stay
    mains_frequency: float = 50.0
    supplies: Mapping[str, float] = field(default_factory=dict)  # V, of those that are wrong
    interlock_closed: bool = True
    slave_silent: bool = False  # a unit of the system does not answer the master
    sense_offset: float = 0.0  # V at the sense lines that are not at the terminals
    sense_reversed: bool = False

    def __post_init__(self) -> None:
        self.unit = self.unit.system(self.units, self.connection)
        self.power_reference = self.unit.nominal_power
        self.overvoltage_level = LEVEL_MARGIN * self.unit.nominal_voltage
        self.overcurrent_level = LEVEL_MARGIN * self.unit.maximum_current


class Plant(Inputs):
    """Ramps, circuit, heat sink and I2t store under these inputs.

    Circuit and heat sink outlive the supply.
    """

    tick: ClassVar[float] = 0.001  # s

    state: StageState
    ticks: int  # since power-on

    def __post_init__(self) -> None:
        super().__post_init__()
        self.circuit = Circuit(self.unit)
        self.heat = HeatSink(self.unit, self.ambient)
        self._supply()

    def _supply(self) -> None:
        """Make anew what does not outlive the supply."""
        self.state = StageState.POWERUP
        self.ticks = 0
        self.ramps = Ramps(self.unit)
        self.store = I2tStore(self.unit)
        self.mains_before = self.mains

    def drain(self, dt: float) -> None:
        """Let `dt` seconds pass without supply, of any length."""
        left = round(dt / self.tick)
        while left:
            ahead = self.ahead if self.load is self.circuit.load else 0.0
            ticks = max(1, int(min(left, ahead / self.tick)))
            (self.coast if ahead and self.circuit.settled else self.flow)(ticks)
            left -= ticks

    @property
    def running(self) -> bool:
        """Whether the output is on."""
        return self.state in ON

    @property
    def mode(self) -> Mode:
        """The limit that holds the output."""
        return self.circuit.mode if self.running else Mode.OFF

    @property
    def voltage(self) -> float:
        """V at the terminals, as measured (7.3.10)."""
        return self.circuit.voltage

    @property
    def current(self) -> float:
        """A into the load, as measured (7.3.11)."""
        return self.circuit.current

    @property
    def power(self) -> float:
        """W, from the two before any rounding (7.3.12)."""
        return self.voltage * self.current

    @property
    def temperature(self) -> float:
        """Of the heat sink, degC."""
        return self.heat.temperature

    @property
    def loss(self) -> float:
        """W into the heat sink; current taken in costs as much as current given out."""
        if self.state not in ON:
            return 0.0
        power = abs(self.circuit.voltage * self.circuit.current)
        return power * (1.0 / self.unit.efficiency - 1.0) + self.unit.idle_power

    @property
    def derated_maximum(self) -> float:
        """A that the heat sink allows now."""
        return self.heat.derating * self.unit.maximum_current

    @property
    def settled(self) -> bool:
        """Whether voltage and current will stay as they are."""
        return self.circuit.settled and self._ramped and not self._heat_bends_output

    @property
    def ahead(self) -> float:
        """Seconds that can pass in one go: 0 while something moves, inf if nothing ever will."""
        if self.mains_slew:
            return 0.0
        if self.settled:
            return self._until_next_level()
        if self.circuit.drift > SLOW or not self._ramped:
            return 0.0
        if self._heat_bends_output:
            return CREEP
        return min(self.circuit.stride, self._until_next_level()) if self.load.stores else 0.0

    def flow(self, ticks: int) -> None:
        """Let `ticks` pass, as one step of the circuit."""
        dt = ticks * self.tick
        self.circuit.step(dt, self._law(dt) if self.running else None, self.load)
        self.coast(ticks)

    def coast(self, ticks: int) -> None:
        """Let `ticks` pass, any number, in which voltage and current stay as they are."""
        dt = ticks * self.tick
        self.heat.step(dt, self.loss, self.ambient)
        self.store.step(dt, self.circuit.current)
        self.ticks += ticks
        if self.mains_slew:
            self._move_mains(ticks)

    def _move_mains(self, ticks: int) -> None:
        way, reach = self.mains_goal - self.mains, self.mains_slew * ticks * self.tick
        if abs(way) <= reach:
            self.mains, self.mains_slew = self.mains_goal, 0.0
        else:
            self.mains += copysign(reach, way)

    def _law(self, dt: float) -> Law:
        ramps, unit, derating = self.ramps, self.unit, self.heat.derating
        ramps.step(dt, self.voltage_reference, self.current_reference)
        return Law(
            ramps.voltage,
            max(self.resistance_reference, unit.droop),
            min(ramps.current, derating * unit.maximum_current),
            self.power_reference,
            derating * unit.sink_current,
        )

    @property
    def _ramped(self) -> bool:
        reached = self.ramps.reached(self.voltage_reference, self.current_reference)
        return reached or not self.running

    @property
    def _heat_bends_output(self) -> bool:
        if self.heat.temperature < WARM or not self.running:
            return False
        end = self.heat.end(self.loss, self.ambient)
        touches = self.heat.derating <= TOUCH * self._used
        return touches and abs(end - self.heat.temperature) > EVEN

    @property
    def _used(self) -> float:
        """Part of the current that the unit can give, or can take in."""
        current, sink = self.circuit.current, self.unit.sink_current
        if current < 0.0:
            return -current / sink if sink else 0.0
        return current / self.unit.maximum_current

    def _until_next_level(self) -> float:
        """Seconds until heat or I2t of a settled plant reach the next level that acts."""
        current, limit = self.circuit.current, self.unit.i2t_limit
        end = self.heat.end(self.loss, self.ambient)
        bend = derated_at(TOUCH * self._used)
        return min(
            *(self.heat.time_to(level, end) for level in (WARM, bend, HOT)),
            *(self.store.time_to(level, current) for level in (limit / 2, limit)),
        )
