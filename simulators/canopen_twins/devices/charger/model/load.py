"""What the charging output feeds: a bar or a resistor, dirt on it, a web under it."""

from dataclasses import dataclass, field
from math import inf
from typing import Protocol

BAR_DECAY = 0.1  # s, time constant with which a bar drains what is left (A-72, assumed)
HOLDING_TIME = 30.0  # s, the same of cable and generator with nothing connected (assumed)
WEB_CAPACITANCE = 1e-9  # F/m2: charge a passing web takes along, per volt (assumed)


class Electrode(Protocol):
    """Anything with a rising characteristic; takes V, gives A."""

    def current(self, voltage: float) -> float:
        """At a voltage."""
        ...

    def decay_rate(self, capacitance: float) -> float:
        """How fast it drains a capacitance (F), in 1/s."""
        ...


@dataclass(frozen=True)
class AirGap:
    """A bar in corona, in the form of Townsend: no current below the onset (assumed)."""

    length: float  # m
    onset: float  # V
    coefficient: float  # A/(V2 m)

    def current(self, voltage: float) -> float:
        """A, at a voltage in V."""
        excess = max(0.0, voltage - self.onset)
        return self.coefficient * self.length * voltage * excess

    def decay_rate(self, capacitance: float) -> float:
        """1/s, below the onset as well: ions and moist surfaces are no part of Townsend's form."""
        return 1 / BAR_DECAY


@dataclass(frozen=True)
class Resistor:
    """An ohmic load."""

    resistance: float  # ohm

    def current(self, voltage: float) -> float:
        """A, at a voltage in V."""
        return voltage / self.resistance

    def decay_rate(self, capacitance: float) -> float:
        """1/s, with a capacitance in F."""
        return 1 / (self.resistance * capacitance)


SHORT = Resistor(1.0)
OPEN = Resistor(inf)


@dataclass(frozen=True)
class Web:
    """The material that is charged or discharged; it stands still unless told otherwise."""

    width: float = 1.5  # m
    speed: float = 0.0  # m/s
    surface_charge: float = 5e-6  # C/m2, what it brings along to the discharging bar

    @property
    def area_rate(self) -> float:
        """Area that passes a bar, in m2/s."""
        return self.width * self.speed


@dataclass(frozen=True)
class Load:
    """All together. Insulating dirt leaves a share of the bar active, conductive dirt leaks."""

    electrode: Electrode
    active: float = 1.0
    leakage: float = 0.0  # S
    web: Web = field(default_factory=Web)
    holding_time: float = HOLDING_TIME  # s, without all of this

    def current(self, voltage: float) -> float:
        """A, at a voltage in V."""
        corona = self.active * self.electrode.current(voltage)
        return corona + voltage * self.leakage + WEB_CAPACITANCE * self.web.area_rate * voltage

    def power(self, voltage: float) -> float:
        """W, at a voltage in V."""
        return voltage * self.current(voltage)

    def decay_rate(self, capacitance: float) -> float:
        """How fast all of it drains a capacitance (F) that is not fed, in 1/s."""
        leaking = self.leakage + WEB_CAPACITANCE * self.web.area_rate
        drained = self.active * self.electrode.decay_rate(capacitance) + leaking / capacitance
        return max(drained, 1 / self.holding_time)
