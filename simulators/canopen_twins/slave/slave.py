"""A canopen `LocalNode` whose objects act: strict look-up, limits, and one way to refuse.

Everything of canopen that is not its public interface is used here and nowhere else.
"""

from collections.abc import Callable, Mapping
from typing import Any

from canopen import LocalNode, ObjectDictionary, SdoAbortedError

from canopen_twins.bus.clock import MICROSECONDS, Scope
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import Wire
from canopen_twins.slave.object import (
    DUMMY_TYPES,
    Abort,
    Address,
    Entry,
    Object,
    Rejected,
    entries_of,
)
from canopen_twins.slave.profile import Profile


class Slave(LocalNode):
    """The dictionary of one node, as the services and the device see it."""

    def __init__(
        self,
        od: ObjectDictionary,
        node_id: int,
        wire: Wire,
        clock: Scope,
        profile: Profile | None = None,
    ) -> None:
        super().__init__(node_id, od)
        self.node_id = node_id
        self.wire = wire
        self.clock = clock  # a reset makes a fresh slave: the timers of this one end with it
        self.shut = False
        """Off the bus for a while: nothing goes out, nothing comes in. A service says so."""
        self.restart = False
        """Whether its communication has to be reset. A service says so."""
        self.active_at = clock.clock.ticks
        """Microsecond of the last frame that came or went."""
        self.stepped: Callable[[], int] = lambda: clock.clock.ticks
        """Microsecond up to which time has passed for the device; its node knows."""
        self.profile = profile or Profile()
        self.entries: dict[int, dict[int, Entry]] = {}
        self.on_communication_change: Callable[[], None] = lambda: None
        self.hear: Callable[[Frame], None] = lambda frame: None
        """What this node sends and hears itself as others do: its own SYNC."""
        self.changes = 0  # of the communication area, for whoever has worked something out from it
        self.errors: dict[str, int] = {}
        """Errors of communication that last: emergency error codes, by what is wrong in words."""
        self.dummies: dict[int, int] = {}  # those the EDS allows, with their bits
        for index, item in od.indices.items():
            if index in DUMMY_TYPES:
                self.dummies[index] = len(item)
            else:
                self._add(index, item)
        for other in list(wire):
            del wire[other]
        wire[node_id] = self

    def _add(self, index: int, item: Any) -> None:
        cell = self.data_store.setdefault(index, {})
        self.entries[index] = {}
        for subindex, variable in entries_of(item).items():
            self.entries[index][subindex] = Entry(variable, cell)

    def keep_application(self, before: "Slave") -> None:
        """Take over what a slave before this one had in its memory beyond 0x1000-0x1FFF."""
        for index, cell in before.data_store.items():
            if index >= 0x2000 and index in self.data_store:
                self.data_store[index].update(cell)

    def bind(self, objects: Mapping[Address, Object], owner: str = "") -> None:
        """Let entries act. Several may act on one entry: the first bound refuses first.

        Raises:
            KeyError: the dictionary has no such entry.
        """
        for (index, subindex), acts in objects.items():
            self.entries[index][subindex].bind(acts, owner)

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
        """The value of an entry that is a number, 0 of one that its file has as something else."""
        value = self.entries[index][subindex].unpack(self.entries[index][subindex].read())
        return int(value) if isinstance(value, int) else 0

    def write(self, entry: Entry, data: bytes) -> None:
        """Take a value over, whoever it comes from.

        Raises:
            Rejected: wrong length, out of the limits, or refused by the device.
        """
        if len(data) != entry.size:
            self.check_length(entry, len(data))
        entry.write(data)
        if entry.communicates:
            self.changes += 1
            self.on_communication_change()

    def check_length(self, entry: Entry, length: int) -> None:
        """Raises `Rejected` if so many bytes do not fit the type of an entry."""
        if entry.size is not None and length != entry.size:
            longer = length > entry.size
            code = self.profile.too_long if longer else self.profile.too_short
            raise Rejected(f"{length} bytes for an object of {entry.size}", code)

    def send(self, frame: Frame) -> None:
        """Send a frame; lost while the slave is off the bus."""
        if not self.shut:
            self.active_at = self.clock.clock.ticks
            self.wire.put(frame)

    @property
    def quiet(self) -> float:
        """Seconds since the last frame that came or went."""
        return (self.clock.clock.ticks - self.active_at) / MICROSECONDS

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
