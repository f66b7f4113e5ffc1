"""Errors and warnings as they go over the bus, and the catalogue that numbers them (A-37)."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from simulators.devices.charger.message_file import read_catalogue
from simulators.devices.charger.model.catalogue import Catalogue, Kind, Message
from simulators.errors import UserError, unknown
from simulators.messages import EmcyMessage
from simulators.resources import od_file
from simulators.services.emcy import FIELD_LENGTH, NO_ERROR, Emcy

SHIPPED = "charger_messages.yaml"
GENERIC = 1 << 0  # of the error register, with every message
CLASS_BIT: Mapping[int, int] = {0x2: 1 << 1, 0x3: 1 << 2, 0x4: 1 << 3}  # by the first digit, A-29
COMMUNICATION, SPECIFIC = {0x81: 1 << 4}, {0xFF: 1 << 7}  # by the first two


def catalogue(file: str) -> Catalogue:
    """The messages of a user's file, or those that are shipped.

    Raises:
        UserError: the file is not what it should be.
    """
    return read_catalogue(Path(file)) if file else _shipped()


@cache
def _shipped() -> Catalogue:
    with od_file(SHIPPED) as path:
        return read_catalogue(path)


@cache
def emcy(message: Message) -> Emcy:
    """A message as it is told: type and number are the error field."""
    label = f"{message.kind.name} {message.number:#04x} {message.key.replace('_', ' ')}"
    return Emcy(message.emcy, message.register, _field(message), label.lower().strip())


def told(messages: Catalogue) -> Mapping[str, EmcyMessage]:
    """All messages as a master is told of them, by kind and number."""
    return {
        f"{message.kind.name.lower()} {message.number:#04x}": EmcyMessage(
            message.key.replace("_", " "), message.emcy, _identity(message)
        )
        for message in messages
    }


def acknowledgement(gone: Emcy, register: int, *, identified: bool) -> Emcy:
    """What is told once a message is cleared, with the register that remains (A-36)."""
    return NO_ERROR._replace(
        register=register, field=gone.field if identified else bytes(FIELD_LENGTH)
    )


def find(messages: Catalogue, kind: Kind, key: str, number: int, code: int) -> Message:
    """A message by its key or its number, or, with a code, any that the catalogue has not.

    Raises:
        UserError: there is none, or no charger can tell it.
    """
    if key and not (number or code):
        known = {message.key for message in messages if message.kind is kind}
        if message := messages.keyed(kind, key):
            return message
        raise unknown(kind.name.lower(), key, known)
    if not code and (message := messages.numbered(kind, number)):
        return message
    try:
        return Message(kind, number, code, _register(code), trips=kind is Kind.ERROR, key=key)
    except ValueError as refusal:
        raise UserError(f"no {kind.name.lower()} like this: {refusal}") from refusal


def _register(code: int) -> int:
    high = code >> 8
    bit = COMMUNICATION.get(high, 0) | SPECIFIC.get(high, 0) | CLASS_BIT.get(high >> 4, 0)
    return GENERIC | bit


def _field(message: Message) -> bytes:
    return _identity(message).ljust(FIELD_LENGTH, b"\0")


def _identity(message: Message) -> bytes:
    return bytes([message.kind.value, message.number])
