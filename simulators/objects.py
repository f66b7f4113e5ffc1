"""How an object of the dictionary acts, and how it refuses."""

from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

Address = tuple[int, int]
Value = int | float | str | bytes


class Abort(IntEnum):
    """SDO abort codes (CiA 301, 7.2.4.3.17)."""

    TOGGLE = 0x05030000
    TIME_OUT = 0x05040000
    COMMAND = 0x05040001
    BLOCK_SIZE = 0x05040002
    SEQUENCE_NUMBER = 0x05040003
    CRC = 0x05040004
    OUT_OF_MEMORY = 0x05040005
    WRITE_ONLY = 0x06010001
    READ_ONLY = 0x06010002
    NO_OBJECT = 0x06020000
    NOT_MAPPABLE = 0x06040041
    PDO_TOO_LONG = 0x06040042
    INCOMPATIBLE = 0x06040043
    HARDWARE = 0x06060000
    LENGTH = 0x06070010
    TOO_LONG = 0x06070012
    TOO_SHORT = 0x06070013
    NO_SUBINDEX = 0x06090011
    INVALID_VALUE = 0x06090030
    TOO_HIGH = 0x06090031
    TOO_LOW = 0x06090032
    NOT_TRANSFERABLE = 0x08000020
    LOCAL_CONTROL = 0x08000021
    DEVICE_STATE = 0x08000022
    NO_DATA = 0x08000024


class Rejected(Exception):  # noqa: N818 - a refusal is an answer of the device, not an error
    """The device refuses a value or an access; the master is answered with an SDO abort."""

    def __init__(self, reason: str, code: int = Abort.INVALID_VALUE) -> None:
        super().__init__(reason)
        self.code = code


class Object(NamedTuple):
    """What reading and writing an entry does; entries nobody names are plain memory of the node.

    An entry with `read` has its value there; one without keeps what was written. `adjust` says
    what the device makes of a written value before it acts and is kept. `write` may raise
    `Rejected`; the old value then stays. `obstacle` says in words why a value that was taken has
    no effect at this moment; empty if it has.
    """

    read: Callable[[], Value] | None = None
    write: Callable[[int], None] | None = None
    adjust: Callable[[int], int] | None = None
    obstacle: Callable[[int], str] | None = None
