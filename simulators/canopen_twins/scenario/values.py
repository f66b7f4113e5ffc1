"""Values of objects: what bytes on the bus mean, what a node has, and which values are meant."""

from dataclasses import dataclass
from math import inf

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES

from canopen_twins.device.node import Node
from canopen_twins.scenario.targets import Target
from canopen_twins.slave.object import Rejected


def value_of(target: Target, data: bytes, sized: bool = True) -> object:
    """A number or a text; bytes where they are neither.

    Args:
        target: The object; one that no dictionary knows is a number.
        data: Its bytes.
        sized: Whether all of them count, or as many as the object has.
    """
    variable = target.variable
    if variable is None or variable.data_type is None:
        return int.from_bytes(data, "little")
    codec = ODVariable.STRUCT_TYPES.get(variable.data_type)
    if codec is None:
        return data.decode("ascii", "replace") if target.is_text else data
    if not sized:
        data = data[: codec.size]
    if len(data) == codec.size:
        return codec.unpack(data)[0]
    return int.from_bytes(data, "little") if variable.data_type in INTEGER_TYPES else data


class NoValue(str):
    """Why there is none; whatever is wanted, this is not it."""

    __slots__ = ()


def value_now(node: Node, target: Target) -> object:
    """What the dictionary of a node has; the look leaves no trace on the bus nor in the device."""
    if node.slave is None:
        return NoValue("(silent)")
    try:
        entry = node.slave.entry(*target.address)
        return entry.unpack(entry.read())
    except Rejected as refusal:
        return NoValue(f"(refused: {refusal})")


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
