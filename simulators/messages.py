"""What a device tells its master of itself when something is wrong, message by message."""

from typing import NamedTuple

from simulators.objects import Address


class EmcyMessage(NamedTuple):
    """An emergency."""

    text: str
    code: int
    """Emergency error code."""
    field: bytes = b""
    """How the manufacturer-specific error field begins; empty for whatever it is."""


class BitMessage(NamedTuple):
    """A bit of an object; set while there is something to tell."""

    text: str
    address: Address
    bit: int


Message = EmcyMessage | BitMessage
