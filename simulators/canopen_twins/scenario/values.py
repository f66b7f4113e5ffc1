"""Values of objects: what bytes mean, what a node has, what is wanted, and what is sent."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    FLOAT_TYPES,
    INTEGER_TYPES,
    SIGNED_TYPES,
    VISIBLE_STRING,
)

from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.files.document import Item
from canopen_twins.files.yaml_nodes import Scalar
from canopen_twins.scenario.targets import Target
from canopen_twins.slave.object import Rejected

LARGEST = 0xFFFF_FFFF  # of an object that no dictionary knows: four bytes go in one frame


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


def encode(target: Target, item: Item, limited: bool) -> bytes:
    """A value of the file as it goes to an object; `limited` by access and limits of the EDS.

    Raises:
        UserError: nobody can write it, it is of another type, or out of the limits.
    """
    if (variable := target.variable) is None:
        return item.whole_up_to(LARGEST).to_bytes(4, "little")
    if limited and not variable.writable:
        raise UserError(
            f"{variable.name!r} is read only; if that is the point, put abort: 0x06010002 beside"
        )
    data_type = variable.data_type or 0
    if data_type == VISIBLE_STRING:
        return _fit(item, lambda: item.text.encode("ascii"))
    if data_type not in ODVariable.STRUCT_TYPES:
        raise UserError(f"objects of data type {data_type:#06x} cannot be written here")
    if data_type == BOOLEAN:
        value: Scalar = item.one_of("truth value", ("true", "false")) == "true"
    elif data_type in FLOAT_TYPES:
        value = item.number
    else:
        value = _in_range(variable, item, limited)
    return _fit(item, lambda: ODVariable.STRUCT_TYPES[data_type].pack(value))


def _in_range(variable: ODVariable, item: Item, limited: bool) -> int:
    bits = len(variable)
    signed = variable.data_type in SIGNED_TYPES
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    if limited:
        low = low if variable.min is None else max(low, variable.min)
        high = high if variable.max is None else min(high, variable.max)
    if not low <= (value := item.whole) <= high:
        hint = "; if that is the point, put the abort code beside" if limited else ""
        raise item.wrong(f"{item.text} is not in {low}..{high}{hint}")
    return value


def _fit(item: Item, pack: Callable[[], bytes]) -> bytes:
    try:
        return pack()
    except (ValueError, OverflowError):
        raise item.wrong(f"{item.text!r} does not fit this object") from None
