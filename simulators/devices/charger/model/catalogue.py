"""The catalogue of messages: numbers, codes and registers for what the model knows by key."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

FORMAT = "charger_messages/1"
CODES = range(0x1000, 0x10000)  # what an EMCY calls an error (EMCY section of the manual)
GENERIC = 1 << 0  # the bit of the error register that every message sets
FIELDS = {"number", "key", "emcy", "register", "trips", "when"}
REQUIRED = FIELDS - {"trips", "when"}


class Kind(Enum):
    """Errors and warnings; the value is the byte `Type` of an EMCY."""

    ERROR = 0x01
    WARNING = 0x05


LISTS = {"errors": Kind.ERROR, "warnings": Kind.WARNING}
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


def read_catalogue(data: object) -> Catalogue:
    """Check the content of a catalogue file, as YAML gives it.

    Raises:
        ValueError: in one line, what is wrong and where.
    """
    if not isinstance(data, Mapping) or data.get("format") != FORMAT:
        raise ValueError(f"this is no catalogue of the format {FORMAT}")
    if unknown := set(data) - {"format", "assumed", *LISTS}:
        raise ValueError(f"unknown entries: {', '.join(sorted(map(str, unknown)))}")
    if not isinstance(data.get("assumed"), bool):
        raise ValueError("assumed is true or false: whether the numbers are guessed")
    return Catalogue([message for name in LISTS for message in _read_list(name, data)])


def _read_list(name: str, data: Mapping[str, Any]) -> Iterator[Message]:
    rows = data.get(name)
    if not isinstance(rows, list):
        raise ValueError(f"{name} is a list of messages")
    for place, row in enumerate(rows, start=1):
        try:
            yield _read_message(LISTS[name], row)
        except ValueError as error:
            raise ValueError(f"{name}, entry {place}: {error}") from None


def _read_message(kind: Kind, row: object) -> Message:
    if not isinstance(row, Mapping):
        raise ValueError("a message is a mapping")
    if odd := (set(row) ^ REQUIRED) - (FIELDS - REQUIRED):
        raise ValueError(f"missing or unknown: {', '.join(sorted(map(str, odd)))}")
    for name in ("number", "emcy", "register"):
        if type(row[name]) is not int:
            raise ValueError(f"{name} is a whole number, not {row[name]!r}")
    if not isinstance(row["key"], str) or not row["key"]:
        raise ValueError(f"key is a word, not {row['key']!r}")
    trips = row.get("trips", False)
    if not isinstance(trips, bool):
        raise ValueError(f"trips is true or false, not {trips!r}")
    return Message(kind, row["number"], row["emcy"], row["register"], trips, row["key"])


def _unique(messages: Collection[Message], field: str) -> dict[tuple[Kind, Any], Message]:
    found: dict[tuple[Kind, Any], Message] = {}
    for message in messages:
        value = getattr(message, field)
        if (message.kind, value) in found:
            raise ValueError(f"two {message.kind.name.lower()}s with the {field} {value!r}")
        found[message.kind, value] = message
    return found
