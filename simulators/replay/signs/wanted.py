"""Which values are meant."""

from dataclasses import dataclass
from math import inf


@dataclass(frozen=True)
class Range:
    """Numbers, both ends included."""

    low: float = -inf
    high: float = inf
    hexadecimal: bool = False
    """Whether values are told in hexadecimal."""

    def tell(self, value: object) -> str:
        """A value, as the file would have it."""
        return f"{value:#06x}" if self.hexadecimal and isinstance(value, int) else f"{value}"

    def __contains__(self, value: object) -> bool:
        return isinstance(value, (int, float)) and self.low <= value <= self.high

    def __str__(self) -> str:
        if self.low == self.high:
            return self.tell(self.low)
        told = f"{self.tell(self.low)}..{self.tell(self.high)}"
        return told.replace("-inf..", "at most ").replace("..inf", " or more")


@dataclass(frozen=True)
class Text:
    """The one text that is meant."""

    text: str

    def tell(self, value: object) -> str:
        """A value in quotes."""
        return repr(value)

    def __contains__(self, value: object) -> bool:
        return value == self.text

    def __str__(self) -> str:
        return repr(self.text)


@dataclass(frozen=True)
class Anything:
    """Whatever it is."""

    def tell(self, value: object) -> str:
        """A value as it is."""
        return f"{value}"

    def __contains__(self, value: object) -> bool:
        return True

    def __str__(self) -> str:
        return "any"


Wanted = Range | Text | Anything
