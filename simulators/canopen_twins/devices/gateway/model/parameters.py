"""Parameters of DcDesk: what they are called, what they may be, and which unit has them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from math import isfinite


class Unit(Enum):
    """The two control units; the same number means different things in them (A-44)."""

    GATEWAY = "gateway"
    GOVERNOR = "governor"


class Kind(Enum):
    """The four lists of chapter 11, told by the number."""

    PARAMETER = 0
    MEASUREMENT = 1
    FUNCTION = 2
    CURVE = 3


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
    def kind(self) -> Kind:
        """Which list of chapter 11 it belongs to; CANopen has numbers of its own from 10000."""
        return Kind(self.number % 10_000 // 2000)

    @property
    def writable(self) -> bool:
        """Measurements are shown only."""
        return self.kind is not Kind.MEASUREMENT

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
        for parameter in parameters:
            table = self._table[parameter.control_unit]
            if parameter.number in table:
                raise ValueError(f"{parameter.title}: the number is there twice")
            table[parameter.number] = parameter

    def of(self, unit: Unit) -> Mapping[int, Parameter]:
        """The parameters of one unit by number."""
        return self._table[unit]

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
    try:
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
    except KeyError as column:
        raise ValueError(f"line {line}: there is no column {column}") from None
    except (ValueError, ZeroDivisionError) as reason:
        raise ValueError(f"line {line}: {reason}") from None
    return parameter


def _range(text: str) -> tuple[float, float, tuple[float, ...]]:
    if "|" in text:
        choices = tuple(_number(choice) for choice in text.split("|"))
        return min(choices), max(choices), choices
    low, _, high = text.partition("..")
    return _number(low), _number(high), ()


def _number(text: str) -> float:
    return float(text) if "." in text else int(text, 0)
