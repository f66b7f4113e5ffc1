"""What flows: converter, output node, heat and I2t store; nothing here knows of errors."""

from dataclasses import dataclass, field
from random import Random
from typing import ClassVar

from simulators.devices.topcon.model.circuit import Circuit
from simulators.devices.topcon.model.heat import HeatSink
from simulators.devices.topcon.model.i2t import I2tStore
from simulators.devices.topcon.model.inputs import Inputs
from simulators.devices.topcon.model.modes import Mode, State
from simulators.devices.topcon.model.ramps import Ramps
from simulators.devices.topcon.model.solver import Law
from simulators.devices.topcon.model.unit import FULL_SCALE


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
