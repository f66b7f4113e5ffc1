"""One entry of the object dictionary, with everything worked out that a frame asks for."""

from collections.abc import Callable
from typing import Any

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES

from simulators.objects import Abort, Address, Object, Rejected, Value


class Entry:
    """Its value is where one of its objects has it, otherwise in the node's data store."""

    __slots__ = (
        "_cell",
        "acts",
        "address",
        "high",
        "low",
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
        self.acts: list[Object] = []
        self._cell = cell
        cell[variable.subindex] = self._initial()

    def read(self) -> bytes:
        """The value as it goes over the wire."""
        for acts in self.acts:
            if acts.read is not None:
                value = acts.read()
                return value if isinstance(value, bytes) else self.pack(value)
        return self._cell[self.variable.subindex]

    def write(self, data: bytes) -> None:
        """Take a value of the right length over.

        Raises:
            Rejected: out of the limits of the EDS, or refused by the device.
        """
        if self.low is not None or self.high is not None or self.acts:
            data = self._act(data)
        self._cell[self.variable.subindex] = data

    def _act(self, data: bytes) -> bytes:
        value = self.unpack(data)
        if self.high is not None and value > self.high:
            raise Rejected(f"{value} is above {self.high}", Abort.TOO_HIGH)
        if self.low is not None and value < self.low:
            raise Rejected(f"{value} is below {self.low}", Abort.TOO_LOW)
        for acts in self.acts:
            if acts.adjust is not None:
                value = acts.adjust(value)
        for acts in self.acts:
            if acts.write is not None:
                acts.write(value)
        return self.pack(value)

    def _initial(self) -> bytes:
        """ParameterValue or DefaultValue of the EDS; zero for a number that has neither."""
        variable: Any = self.variable
        value: Value | None = variable.default if variable.value is None else variable.value
        if value is None:
            return bytes(self.size or 0)
        return value if isinstance(value, bytes) else self.pack(value)


def _first(codec: Any) -> Callable[[bytes], Any]:
    unpack = codec.unpack
    return lambda data: unpack(data)[0]
