"""What can be connected to the output, each as a line of current over voltage, and its text."""

from abc import ABC, abstractmethod
from dataclasses import MISSING, Field, dataclass, field, fields
from math import isfinite
from typing import Any, ClassVar

SHORT = 0.002  # ohm, assumed
KNEE = 1.0  # V under which a sink can no longer hold its current, assumed
NO_LIMIT = float("inf")
HOUR = 3600  # s
HALF = 0.5  # state of charge at which a battery has the voltage it is called by
OHM, HENRY, FARAD, CUT_OFF = (
    {"unit": unit, "may_be_zero": False} for unit in ("ohm", "H", "F", "V")
)
VOLT, AMPERE, WATT, AMPERE_HOUR = (
    {"unit": unit, "may_be_zero": True} for unit in ("V", "A", "W", "Ah")
)
SHARE = {"unit": "", "may_be_zero": True, "most": 1.0}  # of no unit, so its name stands before it

Line = tuple[float, float, float, float]
"""Conductance, offset, lowest and highest: i(u) = conductance * u + offset, held between the two.

The conductance is never negative, so the node equation has one solution.
"""


# A load has its methods by inheritance: Python makes those of a frozen dataclass one by one, which
# for all loads took a tenth of the time until the first twin of a process has booted.
@dataclass(eq=False, repr=False)
class Load(ABC):
    """What draws current from the output. Raises ValueError for a value that cannot be.

    Nobody changes one; two are equal that are of one kind and have the same values.
    """

    word: ClassVar[str]

    def __post_init__(self) -> None:
        for quantity in (part for part in fields(self) if part.metadata):
            value, may_be_zero = getattr(self, quantity.name), quantity.metadata["may_be_zero"]
            if not (isfinite(value) and (value > 0 or (value == 0 and may_be_zero))):
                least = "0 or more" if may_be_zero else "above 0"
                raise ValueError(f"load {self.word!r}: {quantity.name} must be {least}")
            if value > quantity.metadata.get("most", value):
                raise ValueError(f"load {self.word!r}: {quantity.name} must be in 0..1")

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and vars(other) == vars(self)

    def __hash__(self) -> int:
        return hash((self.word, *vars(self).values()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(map(repr, vars(self).values()))})"

    @property
    def stores(self) -> bool:
        """Whether its voltage moves with the charge it has taken."""
        return False

    @abstractmethod
    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """The load during the coming `dt` seconds.

        Voltage and current are those before it, `charge` is what has flowed in since the load was
        connected, in As.
        """


class Open(Load):
    """Nothing connected."""

    word: ClassVar[str] = "open"

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """No current."""
        return 0.0, 0.0, -NO_LIMIT, NO_LIMIT


@dataclass(eq=False, repr=False)
class Resistor(Load):
    """Ohm's law."""

    word: ClassVar[str] = "resistor"
    ohm: float = field(metadata=OHM)

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """u / ohm."""
        return 1.0 / self.ohm, 0.0, -NO_LIMIT, NO_LIMIT


class Short(Load):
    """A short circuit, as good as its cables: 2 mOhm."""

    word: ClassVar[str] = "short"

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """u / 2 mOhm."""
        return 1.0 / SHORT, 0.0, -NO_LIMIT, NO_LIMIT


@dataclass(eq=False, repr=False)
class Battery(Load):
    """A voltage behind a resistance; without a diode it also feeds the bleeder.

    With a capacity its voltage rises with the charge, as much below empty and above full as
    between: `volts` at half charge, and `swing` of that from empty to full.
    """

    word: ClassVar[str] = "battery"
    volts: float = field(metadata=VOLT)
    ohm: float = field(metadata=OHM)
    diode: bool = False
    capacity: float = field(default=0.0, metadata=AMPERE_HOUR)  # 0: the voltage stays
    soc: float = field(default=HALF, metadata=SHARE)  # state of charge when it is connected
    swing: float = field(default=0.2, metadata=SHARE)  # assumed

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.soc != HALF and not self.capacity:
            raise ValueError(f"load {self.word!r}: soc is of no use without a capacity in Ah")

    @property
    def stores(self) -> bool:
        """With a capacity."""
        return self.capacity > 0.0

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """(u - its own voltage) / ohm; behind the diode, only if positive."""
        inside, ohm = self.volts, self.ohm
        if self.capacity:
            per_charge = self.volts * self.swing / (self.capacity * HOUR)
            inside += self.volts * self.swing * (self.soc - HALF) + per_charge * charge
            ohm += per_charge * dt
        return 1.0 / ohm, -inside / ohm, 0.0 if self.diode else -NO_LIMIT, NO_LIMIT


@dataclass(eq=False, repr=False)
class Supercapacitor(Load):
    """A capacitance many times that of the output, behind its resistance."""

    word: ClassVar[str] = "supercapacitor"
    farad: float = field(metadata=FARAD)
    ohm: float = field(metadata=OHM)
    volts: float = field(default=0.0, metadata=VOLT)  # when it is connected

    @property
    def stores(self) -> bool:
        """It does nothing else."""
        return True

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """(u - its own voltage) / ohm, the step of the charge by implicit Euler."""
        ohm = self.ohm + dt / self.farad
        return 1.0 / ohm, -(self.volts + charge / self.farad) / ohm, -NO_LIMIT, NO_LIMIT


@dataclass(eq=False, repr=False)
class CurrentSink(Load):
    """An electronic load that holds a current, down to its knee of 1 V."""

    word: ClassVar[str] = "sink"
    amps: float = field(metadata=AMPERE)

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """`amps`, falling to 0 A below the knee."""
        return self.amps / KNEE, 0.0, 0.0, self.amps


@dataclass(eq=False, repr=False)
class PowerSink(Load):
    """An electronic load that holds a power; under its minimum voltage it holds the current.

    It starts from 0 V only on a supply that can give more than watts / minimum.
    """

    word: ClassVar[str] = "power"
    watts: float = field(metadata=WATT)
    minimum: float = field(default=60.0, metadata=CUT_OFF)  # assumed

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """watts / u above the minimum, `amps` of a current sink below."""
        # A current that falls with the voltage could make two solutions of one step, so
        # it is taken as before the step. Where the voltage rests that is no difference.
        amps = self.watts / max(voltage, self.minimum)
        return amps / KNEE, 0.0, 0.0, amps


@dataclass(eq=False, repr=False)
class Inductor(Load):
    """A winding: resistance and inductance in series."""

    word: ClassVar[str] = "inductor"
    ohm: float = field(metadata=OHM)
    henry: float = field(metadata=HENRY)

    def line(self, voltage: float, current: float, dt: float, charge: float = 0.0) -> Line:
        """(henry * i + dt * u) / (henry + ohm * dt), the step of i by implicit Euler."""
        impedance = self.henry + self.ohm * dt
        return dt / impedance, current * self.henry / impedance, -NO_LIMIT, NO_LIMIT


LOADS: dict[str, type[Load]] = {
    load.word: load
    for load in (
        Open,
        Resistor,
        Battery,
        Supercapacitor,
        CurrentSink,
        PowerSink,
        Short,
        Inductor,
    )
}


def parse_load(text: str) -> Load:
    """The load a text describes: a word, its values, after each its unit if liked.

    Raises ValueError with one line that says what would be right.
    """
    word, *rest = text.split() or [""]
    if word not in LOADS:
        from difflib import get_close_matches  # noqa: PLC0415 - only who is wrong needs it

        near = get_close_matches(word, LOADS, n=1)
        hint = f", did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"no load is called {word!r}{hint}: {', '.join(LOADS)}")
    kind = LOADS[word]
    try:
        named_first = sorted(fields(kind), key=_has_a_place)
        values = {part.name: _take(part, rest) for part in named_first}
        if rest:
            raise ValueError(f"{' '.join(rest)!r} is too much")
    except ValueError as refusal:
        raise ValueError(f"load {text!r}: {refusal}, write {_usage(kind)!r}") from None
    return kind(**values)


def _has_a_place(part: "Field[Any]") -> bool:
    """Whether a value is known by where it stands, not by its name."""
    return part.type is not bool and bool(part.metadata["unit"])


def _take(part: "Field[Any]", rest: list[str]) -> Any:
    """Remove a value from the words, one without a name from their front; else the default."""
    if part.type is bool:
        given = part.name in rest
        if given:
            rest.remove(part.name)
        return given
    unit, name = part.metadata["unit"], f"{part.name}="
    named = [word for word in rest if word.startswith(name)]
    word = next(iter(rest if unit else named), "")
    try:
        value = float(_without(unit, word.removeprefix(name)))
    except ValueError:
        if part.default is not MISSING and not named:
            return part.default
        raise ValueError(f"{part.name} is not a number") from None
    rest.remove(word)
    if unit and rest and not _without(unit, rest[0]):
        del rest[0]
    return value


def _without(unit: str, word: str) -> str:
    """A number without its unit, in whatever case and number that is spelled."""
    spellings = (f"{unit}s", unit, "Ω") if unit == "ohm" else (unit,)
    for spelling in spellings if unit else ():
        if word.lower().endswith(spelling.lower()):
            return word[: -len(spelling)]
    return word


def _usage(kind: type[Load]) -> str:
    return " ".join([kind.word, *(_slot(part) for part in fields(kind))])


def _slot(part: "Field[Any]") -> str:
    if part.type is bool:
        return f"[{part.name}]"
    unit = part.metadata["unit"]
    slot = f"<{unit}>" if unit else f"{part.name}=<0..1>"
    return slot if part.default is MISSING else f"[{slot}]"
