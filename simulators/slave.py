"""A canopen `LocalNode` whose objects act: strict look-up, limits, and one way to refuse.

Everything of canopen that is not its public interface is used here and nowhere else.
"""

import pickle
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from canopen import LocalNode, ObjectDictionary, SdoAbortedError, import_od
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES

from simulators.clock import Clock, Scope
from simulators.objects import Abort, Address, Object, Rejected, Value
from simulators.profile import Profile
from simulators.resources import od_file
from simulators.wire import Wire

DUMMIES = range(0x0001, 0x0020)  # data types that fill gaps of a mapping, no objects (CiA 301)
NOTHING = Object()


@cache
def _imported(eds: str, node_id: int) -> bytes:
    """Import once a file and node id: unpickling is twenty times as fast."""
    with od_file(eds) as path:
        return pickle.dumps(import_od(str(path), node_id))


def dictionary(eds: str, node_id: int) -> ObjectDictionary:
    """A fresh object dictionary from a file of od/ (or a path), with `$NODEID` filled in."""
    od: ObjectDictionary = pickle.loads(_imported(eds, node_id))
    return od


class Entry:
    """One entry of the dictionary, with everything worked out that a frame asks for."""

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


class Slave(LocalNode):
    """The dictionary of one node, as the services and the device see it."""

    def __init__(
        self,
        od: ObjectDictionary,
        node_id: int,
        wire: Wire,
        clock: Clock,
        profile: Profile | None = None,
    ) -> None:
        super().__init__(node_id, od)
        self.node_id = node_id
        self.wire = wire
        self.clock = Scope(clock)  # a reset makes a fresh slave: the timers of this one end with it
        self.profile = profile or Profile()
        self.entries: dict[int, dict[int, Entry]] = {}
        self.on_communication_change: Callable[[], None] = lambda: None
        for index, item in od.indices.items():
            if index not in DUMMIES:
                self._add(index, item)
        for other in list(wire):
            del wire[other]
        wire[node_id] = self

    def _add(self, index: int, item: Any) -> None:
        variables = {0: item} if isinstance(item, ODVariable) else item.subindices
        cell = self.data_store.setdefault(index, {})
        self.entries[index] = {}
        for subindex, variable in variables.items():
            self.entries[index][subindex] = entry = Entry(variable, cell)
            cell[subindex] = _initial(entry)

    def keep_application(self, before: "Slave") -> None:
        """Take over what a slave before this one had in its memory beyond 0x1000-0x1FFF."""
        for index, cell in before.data_store.items():
            if index >= 0x2000 and index in self.data_store:
                self.data_store[index].update(cell)

    def bind(self, objects: Mapping[Address, Object]) -> None:
        """Let entries act. Several may act on one entry: the first bound refuses first.

        Raises:
            KeyError: the dictionary has no such entry.
        """
        for (index, subindex), acts in objects.items():
            self.entries[index][subindex].acts.append(acts)

    def entry(self, index: int, subindex: int) -> Entry:
        """The entry at an address.

        Raises:
            Rejected: there is none; the code tells an unknown index from an unknown sub-index.
        """
        try:
            return self.entries[index][subindex]
        except KeyError:
            if index in self.entries:
                raise Rejected("no such sub-index", Abort.NO_SUBINDEX) from None
            raise Rejected("no such object", Abort.NO_OBJECT) from None

    def has(self, index: int, subindex: int = 0) -> bool:
        """Whether the dictionary has an entry at an address."""
        return subindex in self.entries.get(index, ())

    def number(self, index: int, subindex: int = 0) -> int:
        """The value of an entry that is a number."""
        return int(self.entries[index][subindex].unpack(self.entries[index][subindex].read()))

    def write(self, entry: Entry, data: bytes) -> None:
        """Take a value over, whoever it comes from.

        Raises:
            Rejected: wrong length, out of the limits, or refused by the device.
        """
        if len(data) != entry.size:
            self.check_length(entry, len(data))
        entry.write(data)
        if 0x1000 <= entry.address[0] < 0x2000:
            self.on_communication_change()

    def check_length(self, entry: Entry, length: int) -> None:
        """Raises `Rejected` if so many bytes do not fit the type of an entry."""
        if entry.size is not None and length != entry.size:
            longer = length > entry.size
            code = self.profile.too_long if longer else self.profile.too_short
            raise Rejected(f"{length} bytes for an object of {entry.size}", code)

    def get_data(self, index: int, subindex: int, check_readable: bool = False) -> bytes:
        """What canopen's own `node.sdo[...]` reads."""
        try:
            return self.entry(index, subindex).read()
        except Rejected as refusal:
            raise SdoAbortedError(refusal.code) from refusal

    def set_data(
        self, index: int, subindex: int, data: bytes, check_writable: bool = False
    ) -> None:
        """What canopen's own `node.sdo[...]` writes."""
        try:
            self.write(self.entry(index, subindex), bytes(data))
        except Rejected as refusal:
            raise SdoAbortedError(refusal.code) from refusal


def _first(codec: Any) -> Callable[[bytes], Any]:
    unpack = codec.unpack
    return lambda data: unpack(data)[0]


def _initial(entry: Entry) -> bytes:
    """ParameterValue or DefaultValue of the EDS; zero for a number that has neither."""
    variable: Any = entry.variable
    value: Value | None = variable.default if variable.value is None else variable.value
    if value is None:
        return bytes(entry.size or 0)
    return value if isinstance(value, bytes) else entry.pack(value)
