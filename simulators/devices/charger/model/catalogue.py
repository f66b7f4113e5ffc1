"""The catalogue of messages: numbers, codes and registers for what the model knows by key."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any

CODES = range(0x1000, 0x10000)  # what an EMCY calls an error (EMCY section of the manual)
GENERIC = 1 << 0  # the bit of the error register that every message sets


class Kind(Enum):
    """Errors and warnings; the value is the byte `Type` of an EMCY."""

    ERROR = 0x01
    WARNING = 0x05


NUMBERS = {Kind.ERROR: range(1, 0x51), Kind.WARNING: range(1, 0x61)}  # 2003h:01h and 02h


@dataclass(frozen=True)
class Message:
    """One error or warning."""

    kind: Kind
    number: int
    emcy: int
    register: int
    trips: bool = False  # whether it switches off and blocks
    key: str = ""

    def __post_init__(self) -> None:
        """Raises ValueError for numbers that no EMCY and no clear object can carry."""
        numbers = NUMBERS[self.kind]
        if self.number not in numbers:
            raise ValueError(f"number {self.number:#04x} is not in 0x01..{numbers[-1]:#04x}")
        if self.emcy not in CODES:
            raise ValueError(f"emcy {self.emcy:#06x} is not in 0x1000..0xffff")
        if self.register not in range(0x100) or not self.register & GENERIC:
            raise ValueError(f"register {self.register:#04x} is no byte with bit 0 set")
        if self.trips and self.kind is Kind.WARNING:
            raise ValueError("a warning does not trip")


class Catalogue:
    """All messages, found by kind and key or by kind and number."""

    def __init__(self, messages: Collection[Message]) -> None:
        """Raises ValueError where two messages share a number or a key."""
        self._by_number = _unique(messages, "number")
        self._by_key = _unique([message for message in messages if message.key], "key")

    def __iter__(self) -> Iterator[Message]:
        return iter(self._by_number.values())

    def numbered(self, kind: Kind, number: int) -> Message | None:
        """The message with this number, if there is one."""
        return self._by_number.get((kind, number))

    def keyed(self, kind: Kind, key: str) -> Message | None:
        """The message for what the model knows by this key; without one it is not reported."""
        return self._by_key.get((kind, key))


def _unique(messages: Collection[Message], field: str) -> dict[tuple[Kind, Any], Message]:
    found: dict[tuple[Kind, Any], Message] = {}
    for message in messages:
        value = getattr(message, field)
        if (message.kind, value) in found:
            raise ValueError(f"two {message.kind.name.lower()}s with the {field} {value!r}")
        found[message.kind, value] = message
    return found
