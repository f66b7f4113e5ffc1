"""One entry of the object dictionary, with everything worked out that a frame asks for."""

from collections.abc import Callable
from typing import Any

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES

from simulators.objects import Abort, Address, Object, Rejected, Value


class Entry:
    """Its value is where one of its objects has it, otherwise in the node's data store."""

    __slots__ = (
        "_adjusts",
        "_cell",
        "_source",
        "_writes",
        "address",
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
        codec = ODVariable.STRUCT_TYPES.get(data_type)
        self.variable = variable
        self.readable: bool = variable.readable
        self.writable: bool = variable.writable
        self.address: Address = (variable.index, variable.subindex)
        self.size: int | None = codec.size if codec else None
        self.pack: Callable[[Any], bytes] = codec.pack if codec else variable.encode_raw
        self.unpack: Callable[[bytes], Any] = _first(codec) if codec else variable.decode_raw
        whole = data_type in INTEGER_TYPES
        self.low, self.high = (variable.min, variable.max) if whole else (None, None)
        self.obstacle: Callable[[int], str] | None = None
        self._source: Callable[[], Value] | None = None
        self._adjusts: list[Callable[[int], int]] = []
        self._writes: list[Callable[[int], None]] = []
        self._cell = cell
        cell[variable.subindex] = self.initial

    def bind(self, acts: Object) -> None:
        """Let an object act, after those that do already; the first that has a value is read."""
        self._source = self._source or acts.read
        self.obstacle = self.obstacle or acts.obstacle
        if acts.adjust is not None:
            self._adjusts.append(acts.adjust)
        if acts.write is not None:
            self._writes.append(acts.write)

    def read(self) -> bytes:
        """The value as it goes over the wire."""
        if self._source is None:
            return self._cell[self.variable.subindex]
        value = self._source()
        return value if isinstance(value, bytes) else self.pack(value)

    def write(self, data: bytes) -> None:
        """Take a value of the right length over.

        Raises:
            Rejected: out of the limits of the EDS, or refused by the device.
        """
        limited = self.low is not None or self.high is not None
        if limited or self._adjusts or self._writes:
            data = self._act(data)
        self._cell[self.variable.subindex] = data

    def _act(self, data: bytes) -> bytes:
        value = self.unpack(data)
        if self.high is not None and value > self.high:
            raise Rejected(f"{value} is above {self.high}", Abort.TOO_HIGH)
        if self.low is not None and value < self.low:
            raise Rejected(f"{value} is below {self.low}", Abort.TOO_LOW)
        for adjust in self._adjusts:
            value = adjust(value)
        for write in self._writes:
            write(value)
        return self.pack(value)

    @property
    def initial(self) -> bytes:
        """ParameterValue or DefaultValue of the EDS; zero for a number that has neither."""
        variable: Any = self.variable
        value: Value | None = variable.default if variable.value is None else variable.value
        if value is None:
            return bytes(self.size or 0)
        return value if isinstance(value, bytes) else self.pack(value)


def _first(codec: Any) -> Callable[[bytes], Any]:
    unpack = codec.unpack
    return lambda data: unpack(data)[0]
