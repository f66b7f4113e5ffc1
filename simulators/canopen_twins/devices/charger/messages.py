"""The catalogue of messages as a file lists it, and each message as it is told by EMCY."""

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

from canopen_twins.device import Emcy, EmcyMessage
from canopen_twins.devices.charger.model.messages import Catalogue, Message, Severity
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item, understand, values
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.emcy import FIELD_LENGTH, NO_ERROR

FORMAT = "charger_messages/1"
GENERIC = 1 << 0  # of the error register, with every message
CLASS_BIT: Mapping[int, int] = {0x2: 1 << 1, 0x3: 1 << 2, 0x4: 1 << 3}  # by the first digit, A-29
COMMUNICATION, SPECIFIC = {0x81: 1 << 4}, {0xFF: 1 << 7}  # by the first two


def read_catalogue(path: Path) -> Catalogue:
    """The messages of a file.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    return understand(path, _catalogue)


def _catalogue(file: Item) -> Catalogue:
    told = values(file, KEYS)
    return Catalogue([*told["errors"], *told["warnings"]])


def _key(item: Item) -> str:
    if not item.text:
        raise item.wrong("empty; a key is a word")
    return item.text


def _messages(rows: Item, severity: Severity) -> list[Message]:
    messages: list[Message] = []
    for row in rows.items:
        with row.problems.at(row):
            told = values(row, ROW, optional=("trips", "when"))
            told.pop("when", None)  # for the reader
            try:
                messages = list(Catalogue([*messages, Message(severity, **told)]))
            except ValueError as refusal:
                raise UserError(str(refusal)) from refusal
    return messages


KEYS: Mapping[str, Callable[[Item], Any]] = {
    "format": lambda item: item.one_of("format", [FORMAT]),
    "assumed": lambda item: item.truth,
    "errors": partial(_messages, severity=Severity.ERROR),
    "warnings": partial(_messages, severity=Severity.WARNING),
}
ROW: Mapping[str, Callable[[Item], Any]] = {
    "number": lambda item: item.whole,
    "key": _key,
    "emcy": lambda item: item.whole,
    "register": lambda item: item.whole,
    "trips": lambda item: item.truth,
    "when": lambda item: item.text,
}


def catalogue(file: str) -> Catalogue:
    """The messages of a user's file, or those that are shipped.

    Raises:
        UserError: the file is not what it should be.
    """
    return read_catalogue(Path(file)) if file else _shipped()


@cache
def _shipped() -> Catalogue:
    with od_file("charger_messages.yaml") as path:
        return read_catalogue(path)


@cache
def emcy(message: Message) -> Emcy:
    """A message as it is told: type and number are the error field."""
    label = f"{message.severity.name} {message.number:#04x} {message.key.replace('_', ' ')}"
    field = _identity(message).ljust(FIELD_LENGTH, b"\0")
    return Emcy(message.emcy, message.register, field, label.lower().strip())


def told(messages: Catalogue) -> Mapping[str, EmcyMessage]:
    """All messages as a master is told of them, by kind and number."""
    return {
        f"{message.severity.name.lower()} {message.number:#04x}": EmcyMessage(
            message.key.replace("_", " "), message.emcy, _identity(message)
        )
        for message in messages
    }


def acknowledgement(gone: Emcy, register: int, *, identified: bool) -> Emcy:
    """What is told once a message is cleared, with the register that remains (A-36)."""
    return NO_ERROR._replace(
        register=register, field=gone.field if identified else bytes(FIELD_LENGTH)
    )


def find(messages: Catalogue, severity: Severity, key: str, number: int, code: int) -> Message:
    """A message by its key or its number, or, with a code, any that the catalogue has not.

    Raises:
        UserError: there is none, or no charger can tell it.
    """
    if key and not (number or code):
        known = {message.key for message in messages if message.severity is severity}
        if message := messages.keyed(severity, key):
            return message
        raise unknown(severity.name.lower(), key, known)
    if not code and (message := messages.numbered(severity, number)):
        return message
    try:
        trips = severity is Severity.ERROR
        return Message(severity, number, code, _register(code), trips, key)
    except ValueError as refusal:
        raise UserError(f"no {severity.name.lower()} like this: {refusal}") from refusal


def _register(code: int) -> int:
    high = code >> 8
    bit = COMMUNICATION.get(high, 0) | SPECIFIC.get(high, 0) | CLASS_BIT.get(high >> 4, 0)
    return GENERIC | bit


def _identity(message: Message) -> bytes:
    return bytes([message.severity.value, message.number])
