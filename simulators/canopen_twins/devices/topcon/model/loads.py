"""What can be connected to the output, each as a line of current over voltage, and its text."""

from abc import ABC, abstractmethod
from dataclasses import MISSING, Field, dataclass, field, fields
from difflib import get_close_matches
from math import isfinite
from typing import Any, ClassVar

SHORT = 0.002  # ohm, assumed
KNEE = 1.0  # V under which a sink can no longer hold its current, assumed
NO_LIMIT = float("inf")
OHM, HENRY, CUT_OFF = ({"unit": unit, "may_be_zero": False} for unit in ("ohm", "H", "V"))
VOLT, AMPERE, WATT = ({"unit": unit, "may_be_zero": True} for unit in ("V", "A", "W"))

Line = tuple[float, float, float, float]
"""Conductance, offset, lowest and highest: i(u) = conductance * u + offset, held between the two.

The conductance is never negative, so the node equation has one solution.
"""


@dataclass(frozen=True)
class Load(ABC):
    """What draws current from the output. Raises ValueError for a value that cannot be."""

    word: ClassVar[str]

    def __post_init__(self) -> None:
        for quantity in (part for part in fields(self) if part.metadata):
            value, may_be_zero = getattr(self, quantity.name), quantity.metadata["may_be_zero"]
            if not (isfinite(value) and (value > 0 or (value == 0 and may_be_zero))):
                least = "0 or more" if may_be_zero else "above 0"
                raise ValueError(f"load {self.word!r}: {quantity.name} must be {least}")

    @abstractmethod
    def line(self, voltage: float, current: float, dt: float) -> Line:
        """The load during the coming `dt` seconds; voltage and current are those before it."""


@dataclass(frozen=True)
class Open(Load):
    """Nothing connected."""

    word: ClassVar[str] = "open"

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """No current."""
        return 0.0, 0.0, -NO_LIMIT, NO_LIMIT


@dataclass(frozen=True)
class Resistor(Load):
    """Ohm's law."""

    word: ClassVar[str] = "resistor"
    ohm: float = field(metadata=OHM)

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """u / ohm."""
        return 1.0 / self.ohm, 0.0, -NO_LIMIT, NO_LIMIT


@dataclass(frozen=True)
class Short(Load):
    """A short circuit, as good as its cables: 2 mOhm."""

    word: ClassVar[str] = "short"

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """u / 2 mOhm."""
        return 1.0 / SHORT, 0.0, -NO_LIMIT, NO_LIMIT


@dataclass(frozen=True)
class Battery(Load):
    """A voltage behind a resistance; without a diode it also feeds the bleeder."""

    word: ClassVar[str] = "battery"
    volts: float = field(metadata=VOLT)
    ohm: float = field(metadata=OHM)
    diode: bool = False

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """(u - volts) / ohm; behind the diode, only if positive."""
        lowest = 0.0 if self.diode else -NO_LIMIT
        return 1.0 / self.ohm, -self.volts / self.ohm, lowest, NO_LIMIT


@dataclass(frozen=True)
class CurrentSink(Load):
    """An electronic load that holds a current, down to its knee of 1 V."""

    word: ClassVar[str] = "sink"
    amps: float = field(metadata=AMPERE)

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """`amps`, falling to 0 A below the knee."""
        return self.amps / KNEE, 0.0, 0.0, self.amps


@dataclass(frozen=True)
class PowerSink(Load):
    """An electronic load that holds a power; under its minimum voltage it holds the current.

    It starts from 0 V only on a supply that can give more than watts / minimum.
    """

    word: ClassVar[str] = "power"
    watts: float = field(metadata=WATT)
    minimum: float = field(default=60.0, metadata=CUT_OFF)  # assumed

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """watts / u above the minimum, `amps` of a current sink below."""
        # A current that falls with the voltage could make two solutions of one step, so
        # it is taken as before the step. Where the voltage rests that is no difference.
        amps = self.watts / max(voltage, self.minimum)
        return amps / KNEE, 0.0, 0.0, amps


@dataclass(frozen=True)
class Inductor(Load):
    """A winding: resistance and inductance in series."""

    word: ClassVar[str] = "inductor"
    ohm: float = field(metadata=OHM)
    henry: float = field(metadata=HENRY)

    def line(self, voltage: float, current: float, dt: float) -> Line:
        """(henry * i + dt * u) / (henry + ohm * dt), the step of i by implicit Euler."""
        impedance = self.henry + self.ohm * dt
        return dt / impedance, current * self.henry / impedance, -NO_LIMIT, NO_LIMIT


LOADS: dict[str, type[Load]] = {
    load.word: load for load in (Open, Resistor, Battery, CurrentSink, PowerSink, Short, Inductor)
}


def parse_load(text: str) -> Load:
    """The load a text describes: a word, its values in SI units, a unit word after each if liked.

    Raises ValueError with one line that says what would be right.
    """
    word, *rest = text.split() or [""]
    if word not in LOADS:
        near = get_close_matches(word, LOADS, n=1)
        hint = f", did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"no load is called {word!r}{hint}: {', '.join(LOADS)}")
    kind = LOADS[word]
    try:
        values = {part.name: _take(part, rest) for part in fields(kind)}
        if rest:
            raise ValueError(f"{' '.join(rest)!r} is too much")
    except ValueError as refusal:
        raise ValueError(f"load {text!r}: {refusal}, write {_usage(kind)!r}") from None
    return kind(**values)


def _take(part: "Field[Any]", rest: list[str]) -> Any:
    """Remove a value from the front of the words; where none is, the default."""
    if part.type is bool:
        given = rest[:1] == [part.name]
        del rest[: int(given)]
        return given
    if not rest and part.default is not MISSING:
        return part.default
    try:
        value = float(rest.pop(0))
    except (IndexError, ValueError):
        raise ValueError(f"{part.name} is not a number") from None
    if rest and rest[0] == part.metadata["unit"]:
        del rest[0]
    return value


def _usage(kind: type[Load]) -> str:
    return " ".join([kind.word, *(_slot(part) for part in fields(kind))])


def _slot(part: "Field[Any]") -> str:
    if part.type is bool:
        return f"[{part.name}]"
    slot = f"<{part.metadata['unit']}>"
    return slot if part.default is MISSING else f"[{slot}]"
