"""How an object of the dictionary acts, and how it refuses."""

import struct
from collections.abc import Callable, Mapping
from enum import IntEnum
from math import isfinite
from typing import Any, NamedTuple

from canopen.objectdictionary import ODVariable, datatypes
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    FLOAT_TYPES,
    INTEGER_TYPES,
    TIME_DIFFERENCE,
    TIME_OF_DAY,
)

from canopen_twins.errors import UserError

Address = tuple[int, int]
Value = int | float | str | bytes
TYPES = {
    number: name
    for name, number in vars(datatypes).items()
    if isinstance(number, int) and name.isupper()
}
"""The data types of CiA 301 by their numbers."""
COMMUNICATION_AREA = range(0x1000, 0x2000)
DUMMY_TYPES = range(0x0001, 0x0020)  # data types that fill gaps of a mapping, no objects (CiA 301)
TIMES = (TIME_OF_DAY, TIME_DIFFERENCE)
TIME_SIZE = 6  # bytes: milliseconds in 28 bits, four of no use, days in 16 (CiA 301, 7.1.6.5)
SIZES = dict.fromkeys(TIMES, TIME_SIZE)
"""In bytes, of types that are no numbers."""


def entries_of(item: Any) -> dict[int, ODVariable]:
    """The entries of an object of canopen by sub-index, whatever kind of object it is."""
    return {0: item} if isinstance(item, ODVariable) else item.subindices


class Abort(IntEnum):
    """SDO abort codes (CiA 301, 7.2.4.3.17)."""

    TOGGLE = 0x05030000
    TIME_OUT = 0x05040000
    COMMAND = 0x05040001
    BLOCK_SIZE = 0x05040002
    SEQUENCE_NUMBER = 0x05040003
    CRC = 0x05040004
    ACCESS = 0x06010000
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
        if not isinstance(reason, str):
            raise UserError(
                f"Rejected({reason!r}, {code!r}): the reason comes first, then the code of the"
                ' abort, as in Rejected("too fast", Abort.TOO_HIGH)'
            )
        super().__init__(reason)
        self.code = code


class Object(NamedTuple):
    """What reading and writing an entry does; entries nobody names are plain memory of the node.

    An entry with `read` has its value there, which looks and changes nothing; one without keeps
    what was written. `adjust` says what the device makes of a written value before it acts and is
    kept. `write` may raise `Rejected`; the old value then stays. `obstacle` says in words why a
    value that was taken has no effect at this moment; empty if it has.
    """

    read: Callable[[], Value] | None = None
    write: Callable[[int], None] | None = None
    adjust: Callable[[int], int] | None = None
    obstacle: Callable[[int], str] | None = None


def _first(codec: Any) -> Callable[[bytes], Any]:
    unpack = codec.unpack
    return lambda data: unpack(data)[0]


WHOLE = frozenset(INTEGER_TYPES)
CODECS: Mapping[int, tuple[int, Callable[[Any], bytes], Callable[[bytes], Any]]] = {
    data_type: (codec.size, codec.pack, _first(codec))
    for data_type, codec in ODVariable.STRUCT_TYPES.items()
}
"""Of types that are numbers: how many bytes, to bytes, and from them."""


class Entry:
    """Its value is where one of its objects has it, otherwise in the node's data store."""

    __slots__ = (
        "_adjusts",
        "_bit",
        "_cell",
        "_owner",
        "_source",
        "_verbatim",
        "_writes",
        "address",
        "communicates",
        "high",
        "low",
        "obstacle",
        "pack",
        "readable",
        "size",
        "unpack",
        "variable",
        "writable",
    )

    def __init__(self, variable: ODVariable, cell: dict[int, bytes]) -> None:
        data_type: int = variable.data_type or 0
        self.variable = variable
        self.readable: bool = variable.readable
        self.writable: bool = variable.writable
        self.address: Address = (variable.index, variable.subindex)
        self.communicates = variable.index in COMMUNICATION_AREA
        self.size: int | None
        self.pack: Callable[[Any], bytes]
        self.unpack: Callable[[bytes], Any]
        if data_type in CODECS:
            self.size, self.pack, self.unpack = CODECS[data_type]
        else:
            self.size = SIZES.get(data_type)
            self.pack, self.unpack = variable.encode_raw, variable.decode_raw
        self.obstacle: Callable[[int], str] | None = None
        self._source: Callable[[], Value] | None = None
        self._adjusts: tuple[Callable[[int], int], ...] = ()
        self._writes: tuple[Callable[[int], None], ...] = ()
        self._bit = data_type == BOOLEAN
        self.low, self.high = self._limits()
        self._verbatim = self.is_whole and not self._bit  # packed, a value is what was unpacked
        self._owner = ""
        self._cell = cell
        cell[variable.subindex] = self.initial

    @property
    def is_whole(self) -> bool:
        """Whether its type is one of integers."""
        return self.variable.data_type in WHOLE

    def _limits(self) -> tuple[Any, Any]:
        """Those of a number, as its type has them: 0.1 is not the same in 32 bits and in 64."""
        low, high = self.variable.min, self.variable.max
        if low is None and high is None and not self._bit:
            return None, None
        if self.variable.data_type == BOOLEAN:
            return low, 1 if high is None else high
        if self.variable.data_type in FLOAT_TYPES:
            rounded = [None if x is None else self.unpack(self.pack(x)) for x in (low, high)]
            return rounded[0], rounded[1]
        return (low, high) if self.is_whole else (None, None)

    def bind(self, acts: Object, owner: str = "") -> None:
        """Let an object act, after those that do already; the first that has a value is read.

        `owner` is whose object it is, for whoever has to mend it.
        """
        if self._source is None and acts.read is not None:
            self._source, self._owner = acts.read, owner
        self.obstacle = self.obstacle or acts.obstacle
        if acts.adjust is not None:
            self._adjusts += (acts.adjust,)
        if acts.write is not None:
            self._writes += (acts.write,)

    @property
    def source(self) -> Callable[[], Value]:
        """Where its value is read; whoever stands in between may set another."""
        cell, subindex = self._cell, self.variable.subindex
        return self._source or (lambda: self.unpack(cell[subindex]))

    @source.setter
    def source(self, source: Callable[[], Value]) -> None:
        self._source = source

    def read(self) -> bytes:
        """The value as it goes over the wire."""
        if self._source is None:
            return self._cell[self.variable.subindex]
        value = self._source()
        if isinstance(value, bytes):
            return value
        try:
            return self.pack(value)
        except (struct.error, AttributeError, TypeError) as refusal:
            if not self._owner:  # a service of ours
                raise
            raise UserError(self._misread(value)) from refusal

    def _misread(self, value: object) -> str:
        index, subindex = self.address
        wanted = TYPES.get(self.variable.data_type or 0, "its type")
        whole = isinstance(value, float) and isfinite(value)
        hint = f", {value:.0f} would" if whole else ""
        return (
            f"{self._owner}: the object 0x{index:04X}:{subindex:02X} {self.variable.name!r} reads"
            f" {value!r}, which does not fit {wanted}{hint}"
        )

    def write(self, data: bytes) -> None:
        """Take a value of the right length over.

        Raises:
            Rejected: out of the limits of the EDS, or refused by the device.
        """
        if self._writes or self.high is not None or self.low is not None or self._adjusts:
            data = self._act(data)
        self._cell[self.variable.subindex] = data

    def _act(self, data: bytes) -> bytes:
        value = self.unpack(data)
        number = data[0] if self._bit else value
        if self.high is not None and not number <= self.high:  # nor is what is not a number
            raise Rejected(f"{number} is above {self.high}", Abort.TOO_HIGH)
        if self.low is not None and not number >= self.low:
            raise Rejected(f"{number} is below {self.low}", Abort.TOO_LOW)
        for adjust in self._adjusts:
            value = adjust(value)
        for write in self._writes:
            write(value)
        return data if self._verbatim and not self._adjusts else self.pack(value)

    @property
    def initial(self) -> bytes:
        """ParameterValue or DefaultValue of the EDS; zero for a number that has neither."""
        variable: Any = self.variable
        value: Value | None = variable.default if variable.value is None else variable.value
        if value is None:
            return bytes(self.size or 0)
        return value if isinstance(value, bytes) else self.pack(value)
