"""Parameters of DcDesk: which unit has them, what they may be, their values, their 16 bits."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from math import isfinite
from typing import NamedTuple


class Unit(Enum):
    """The two control units; the same number means different things in them (A-44)."""

    GATEWAY = "gateway"
    GOVERNOR = "governor"


# 7.1.1: the example calls by these numbers what the text calls 416 and 4416
ALIASES: Mapping[tuple[Unit, int], int] = {
    (Unit.GOVERNOR, 409): 416,
    (Unit.GOVERNOR, 4409): 4416,
}


@dataclass(frozen=True)
class Parameter:
    """One parameter of one control unit."""

    control_unit: Unit
    number: int
    name: str
    low: float
    high: float
    choices: tuple[float, ...]
    """The only values allowed, where the manual lists them instead of a range."""
    resolution: float
    level: int
    unit: str
    default: float
    source: str
    """Chapter of the manual, or number of the assumption."""

    @property
    def writable(self) -> bool:
        """Measurements are only shown: 2000 to 3999, and for CANopen 12000 to 13999 (11)."""
        return self.number % 10_000 // 2000 != 1

    @property
    def analogue(self) -> bool:
        """Whether it can be sent in a TPDO: 8 or 16 bits, not a single one (4.1.2)."""
        return (self.low, self.high) != (0, 1)

    @property
    def signed(self) -> bool:
        """Whether it goes to 2002h, not to 2001h."""
        return self.low < 0

    @property
    def title(self) -> str:
        """How it is called in messages."""
        return f"{self.control_unit.value} {self.number} {self.name}"

    def checked(self, value: object) -> float:
        """The value as this parameter takes it.

        Raises:
            ValueError: not a number, out of range, or between two steps of the resolution.
        """
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
            raise ValueError(f"{self.title}: {value!r} is not a number")
        if self.choices and value not in self.choices:
            allowed = ", ".join(f"{choice:g}" for choice in self.choices)
            raise ValueError(f"{self.title}: {value!r} is none of {allowed}")
        if not self.low <= value <= self.high:
            raise ValueError(f"{self.title}: {value!r} is not in {self.low:g}..{self.high:g}")
        steps = round(value / self.resolution)
        if abs(value - steps * self.resolution) > self.resolution / 1000:
            raise ValueError(f"{self.title}: {value!r} is no multiple of {self.resolution:g}")
        return int(value) if self.resolution == 1 else float(value)


class Catalogue:
    """Every parameter of both units, found by number or name."""

    def __init__(self, parameters: Iterable[Parameter]) -> None:
        self._table: dict[Unit, dict[int, Parameter]] = {unit: {} for unit in Unit}
        self._defaults: dict[tuple[Unit, bool], Mapping[int, float]] = {}
        for parameter in parameters:
            table = self._table[parameter.control_unit]
            if parameter.number in table:
                raise ValueError(f"{parameter.title}: the number is there twice")
            table[parameter.number] = parameter

    def of(self, unit: Unit) -> Mapping[int, Parameter]:
        """The parameters of one unit by number."""
        return self._table[unit]

    def defaults(self, unit: Unit, *, writable: bool) -> Mapping[int, float]:
        """Of its parameters that are set, or of those that are only shown."""
        if (unit, writable) not in self._defaults:
            wanted = [each for each in self.of(unit).values() if each.writable == writable]
            self._defaults[unit, writable] = {each.number: each.default for each in wanted}
        return self._defaults[unit, writable]

    def find(self, unit: Unit, key: int | str) -> Parameter:
        """The parameter with this number or name.

        Raises:
            ValueError: the unit has no such parameter.
        """
        table = self.of(unit)
        if isinstance(key, str):
            return self._named(unit, key)
        number = key if type(key) is int else -1
        number = ALIASES.get((unit, number), number)
        if number not in table:
            raise ValueError(f"the {unit.value} has no parameter {key!r}")
        return table[number]

    def _named(self, unit: Unit, name: str) -> Parameter:
        names = {parameter.name: parameter for parameter in self.of(unit).values()}
        if name not in names:
            near = get_close_matches(name, names, n=1)
            hint = f", did you mean {near[0]!r}?" if near else ""
            raise ValueError(f"the {unit.value} has no parameter {name!r}{hint}")
        return names[name]


def catalogue(rows: Iterable[Mapping[str, str]]) -> Catalogue:
    """The parameters of a table, one a row.

    Columns: control_unit, number, name, range, resolution, level, unit, default, source.
    A range is `low..high`, or the allowed values with `|` between them; 0x marks hexadecimal.

    Raises:
        ValueError: a row that cannot be read, or a number that is there twice.
    """
    return Catalogue(_parameter(line, row) for line, row in enumerate(rows, start=2))


def _parameter(line: int, row: Mapping[str, str]) -> Parameter:
    with _row(line):
        low, high, choices = _range(row["range"])
        parameter = Parameter(
            control_unit=Unit(row["control_unit"]),
            number=int(row["number"]),
            name=row["name"],
            low=low,
            high=high,
            choices=choices,
            resolution=float(row["resolution"]),
            level=int(row["level"]),
            unit=row["unit"],
            default=_number(row["default"]),
            source=row["source"],
        )
        parameter.checked(parameter.default)
    return parameter


@contextmanager
def _row(line: int) -> Iterator[None]:
    """What is wrong with a row is told with its line."""
    try:
        yield
    except KeyError as column:
        raise ValueError(f"line {line}: there is no column {column}") from None
    except (ValueError, ZeroDivisionError) as reason:
        raise ValueError(f"line {line}: {reason}") from None


def _range(text: str) -> tuple[float, float, tuple[float, ...]]:
    if "|" in text:
        choices = tuple(_number(choice) for choice in text.split("|"))
        return min(choices), max(choices), choices
    low, _, high = text.partition("..")
    return _number(low), _number(high), ()


def _number(text: str) -> float:
    return float(text) if "." in text else int(text, 0)


class Store:
    """A changed value acts after it was saved and the unit was reset; otherwise it is lost (7)."""

    def __init__(self, defaults: Mapping[int, float]) -> None:
        self._defaults = defaults
        self._edited: dict[int, float] = {}
        self._effective = defaults
        self._damaged = False  # what was saved could not be read at the last start
        self.saved: dict[int, float] = {}
        """What is kept without power, where it differs from the default."""

    def edit(self, number: int, value: float) -> None:
        """Change a value in the working memory."""
        self._edited[number] = value

    def shown(self, number: int) -> float:
        """The value DcDesk shows: the edited one."""
        return self._edited.get(number, self._found.get(number, self._defaults[number]))

    def save(self) -> None:
        """Keep what was edited."""
        self._keep(self._found | self._edited)

    def deliver(self, values: Mapping[int, float]) -> None:
        """Keep values as if they had been saved before; they act after a reset."""
        self._keep({**self.saved, **values})

    def _keep(self, values: dict[int, float]) -> None:
        self.saved = {n: values[n] for n in sorted(values) if values[n] != self._defaults[n]}

    @property
    def _found(self) -> dict[int, float]:
        return {} if self._damaged else self.saved

    def load(self, *, damaged: bool = False) -> None:
        """Begin with what was saved; with the defaults if that is damaged (3099 bit 5)."""
        self._edited, self._damaged = {}, damaged
        self._effective = {**self._defaults, **self._found}

    def after_reset(self, *, damaged: bool = False) -> "Store":
        """As the next start finds it, with what was saved or without."""
        store = copy(self)
        store.load(damaged=damaged)
        return store

    def __getitem__(self, number: int) -> int:
        """The value in force of a parameter without decimals."""
        return int(self._effective[number])

    def effective(self, number: int) -> float:
        """The value in force, in the unit of its parameter."""
        return self._effective[number]


class Scale(NamedTuple):
    """So many counts for the full scale, in the unit of the parameter, within the 16 bits."""

    full_scale: float
    counts: int
    signed: bool

    def internal(self, value: float) -> int:
        """The 16 bits a value is sent as, 0..FFFFh; what does not fit is cut off."""
        internal, low = round(value / self.full_scale * self.counts), -0x8000 if self.signed else 0
        return min(max(low, internal), low + 0xFFFF) & 0xFFFF

    def external(self, internal: int) -> float:
        """The value that the 16 unsigned bits of a CANopen sensor stand for."""
        return internal / self.counts * self.full_scale


class Scaling:
    """Internal values of the governor: what a measurement is in 16 bits (7.1.2.2, A-18).

    A parameter without a scale of its own is counted in steps of its resolution.
    """

    def __init__(self, catalogue: Catalogue, scales: Mapping[int, Scale]) -> None:
        self._parameters = catalogue.of(Unit.GOVERNOR)
        self._scales = scales

    def analogue(self, number: int) -> bool:
        """Whether a parameter with this number can be sent in an analogue TPDO (4.1.2)."""
        return number in self._parameters and self._parameters[number].analogue

    def of(self, number: int) -> Scale:
        """How the parameter with this number is counted."""
        parameter = self._parameters[number]
        return self._scales.get(number) or Scale(parameter.resolution, 1, parameter.signed)


def scaling(catalogue: Catalogue, rows: Iterable[Mapping[str, str]]) -> Scaling:
    """The scaling of a table, one measurement a row.

    Columns: number, full_scale, unit (for the reader), counts.

    Raises:
        ValueError: a row that cannot be read, or that no 16 bits can follow.
    """
    scales: dict[int, Scale] = {}
    for line, row in enumerate(rows, start=2):
        with _row(line):
            number = int(row["number"])
            if number in scales:
                raise ValueError(f"{number} is there twice")
            scales[number] = _scale(catalogue.find(Unit.GOVERNOR, number), row)
    return Scaling(catalogue, scales)


def _scale(parameter: Parameter, row: Mapping[str, str]) -> Scale:
    scale = Scale(float(row["full_scale"]), int(row["counts"]), parameter.signed)
    if not parameter.analogue:
        raise ValueError(f"{parameter.title}: a single bit has no scale")
    if not scale.full_scale > 0:
        raise ValueError(f"{parameter.title}: full scale {scale.full_scale:g} is not above 0")
    high = 0x7FFF if parameter.signed else 0xFFFF
    if not 0 < scale.counts <= high:
        raise ValueError(f"{parameter.title}: {scale.counts} counts are not in 1..{high}")
    return scale
