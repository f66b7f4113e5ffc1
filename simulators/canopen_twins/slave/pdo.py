"""PDOs that follow 0x1400..0x1BFF and SYNC (0x1005) as the dictionary has them at that moment.

What a PDO carries, the rules for changing that, and then when it is taken over or sent.
"""

from collections.abc import Callable, Container, Iterator, Mapping
from functools import partial
from typing import NamedTuple

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.eds.reader import DUMMY_TYPES
from canopen_twins.slave.object import Abort, Address, Entry, Object, Rejected
from canopen_twins.slave.service import (
    Listening,
    Service,
    State,
    check_cob_id,
    check_cob_id_change,
)
from canopen_twins.slave.slave import Slave

LONGEST = 64  # bits of a PDO
BYTE = 8
CAN_BE_SENT = frozenset({"ro", "const", "rw", "rwr"})  # access types (CiA 306)
CAN_BE_RECEIVED = frozenset({"wo", "rw", "rww"})


class Mapped(NamedTuple):
    """One part of a PDO; a dummy has no entry and only fills the room."""

    entry: Entry | None
    size: int
    part: slice
    """Its place in the data of the PDO, `size` bytes."""


def mapped(slave: Slave, index: int) -> list[Mapped]:
    """The parts of a PDO in their order, from the mapping record at an index.

    Raises:
        Rejected: the mapping names an object that does not exist.
    """
    parts: list[Mapped] = []
    begin = 0
    for subindex in range(1, slave.number(index) + 1):
        value = slave.number(index, subindex)
        entry = None if value >> 16 in DUMMY_TYPES else slave.entry(value >> 16, value >> 8 & 0xFF)
        size = (value & 0xFF) // BYTE
        parts.append(Mapped(entry, size, slice(begin, begin + size)))
        begin += size
    return parts


def carried(slave: Slave, index: int) -> list[Mapped]:
    """The same for whoever only looks: nothing if the mapping names an object that is not there."""
    try:
        return mapped(slave, index)
    except Rejected:
        return []


class Sync(Service):
    """Which identifier starts synchronous PDOs; they hear it themselves. It is never produced."""

    @property
    def objects(self) -> Mapping[Address, Object]:
        """A new identifier acts at once."""
        return {(0x1005, 0): Object(write=self._check)} if self.slave.has(0x1005) else {}

    def _check(self, value: int) -> None:
        if value & identifiers.PRODUCES:
            raise Rejected("this node does not produce SYNC")
        if value & identifiers.INVALID:
            raise Rejected(f"{value:08X}h: bit 31 is always 0")
        check_cob_id(value)


COB_ID, TRANSMISSION_TYPE = 1, 2  # sub-indices
SYNCHRONOUS = range(241)
PDO_COUNT = 512


class Pdo(Service):
    """Follows its records as they are in the dictionary; `number` counts from 1."""

    communication: int
    mapping: int
    sent: bool
    active_in = frozenset({State.OPERATIONAL})

    def __init__(self, slave: Slave, number: int) -> None:
        super().__init__(slave)
        self.number = number
        self.record = self.communication + number - 1
        self._mapping = self.mapping + number - 1
        # RPDO: bit 30 is of no use there and stays as the EDS has it; strict: it has to be right
        self._fixed = 0 if self.sent else slave.number(self.record, COB_ID) & identifiers.NO_RTR
        self._adjust = None if slave.profile.strict_cob_id else self._adjust_cob_id

    @classmethod
    def numbers(cls, slave: Slave) -> Iterator[int]:
        """The PDOs of this kind that the dictionary has."""
        return (n + 1 for n in range(PDO_COUNT) if cls.communication + n in slave.entries)

    @classmethod
    def identifier(cls, slave: Slave, number: int) -> int | None:
        """That of a PDO of this kind, none while it is off."""
        return identifiers.of_cob_id(slave.number(cls.communication + number - 1, COB_ID))

    @property
    def types(self) -> Container[int]:
        """Transmission types the device offers."""
        raise NotImplementedError

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Checks of COB-ID, transmission type and mapping."""
        return {
            (self.record, COB_ID): Object(write=self._check_cob_id, adjust=self._adjust),
            (self.record, TRANSMISSION_TYPE): Object(write=self._check_type),
            **{
                (self._mapping, subindex): Object(write=partial(self._check_mapping, subindex))
                for subindex, entry in self.slave.entries[self._mapping].items()
                if entry.writable
            },
        }

    @property
    def cob_id(self) -> int | None:
        """The identifier the PDO uses, none while it is off."""
        return self.identifier(self.slave, self.number)

    @property
    def transmission_type(self) -> int:
        """When data are taken over or sent (CiA 301, tables 70 and 72)."""
        return self.slave.number(self.record, TRANSMISSION_TYPE)

    @property
    def sync_id(self) -> int:
        """The identifier of the SYNC message."""
        has = self.slave.has(0x1005)
        return self.slave.number(0x1005) & identifiers.CAN_ID if has else identifiers.SYNC

    def parts(self) -> list[Mapped]:
        """What the PDO carries at this moment."""
        return mapped(self.slave, self._mapping)

    def _adjust_cob_id(self, value: int) -> int:
        return value & ~identifiers.NO_RTR | self._fixed if self._fixed else value

    def _check_cob_id(self, value: int) -> None:
        before = self.slave.number(self.record, COB_ID)
        if self._fixed & ~value:
            raise Rejected("bit 30 of this RPDO is always 1")
        check_cob_id_change(before, value, strict=self.slave.profile.strict_cob_id)

    def _check_type(self, value: int) -> None:
        if value not in self.types:
            raise Rejected(f"no transmission type {value} here")

    def _check_mapping(self, subindex: int, value: int) -> None:
        """The procedure of CiA 301, 7.5.2.36: PDO off, count 0, entries, count."""
        if self.cob_id is not None:
            raise Rejected("a mapping changes while its PDO is off", Abort.DEVICE_STATE)
        if not subindex:
            self._check_count(value)
        elif self.slave.number(self._mapping):
            raise Rejected("a mapping changes while its count is 0", Abort.DEVICE_STATE)
        elif value:
            self._check_mappable(value)

    def _check_count(self, count: int) -> None:
        if count >= len(self.slave.entries[self._mapping]):
            raise Rejected("more parts than the record has", Abort.PDO_TOO_LONG)
        values = [self.slave.number(self._mapping, sub) for sub in range(1, count + 1)]
        for value in values:
            self._check_mappable(value)
        if sum(value & 0xFF for value in values) > LONGEST:
            raise Rejected("a PDO carries 64 bits", Abort.PDO_TOO_LONG)

    def _check_mappable(self, value: int) -> None:
        index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & 0xFF
        if not self.sent and subindex == 0 and self.slave.dummies.get(index) == bits:
            return
        entry = self.slave.entry(index, subindex)
        fits = entry.size is not None and entry.size * BYTE == bits
        may = entry.variable.access_type in (CAN_BE_SENT if self.sent else CAN_BE_RECEIVED)
        if not (entry.variable.pdo_mappable and fits and may):
            raise Rejected(f"{value:08X}h cannot be mapped", Abort.NOT_MAPPABLE)


class Rpdo(Pdo):
    """Hands the values to their objects; what is refused, `tell` hears of with its number."""

    communication, mapping, sent = 0x1400, 0x1600, False

    def __init__(self, slave: Slave, number: int, tell: Callable[[int, Rejected], None]) -> None:
        super().__init__(slave, number)
        self._tell = tell
        self._slices: list[tuple[Entry, slice]] = []
        self._length = 0
        self._waits_for_sync = False
        self._latched: bytes | None = None

    @property
    def types(self) -> Container[int]:
        """Transmission types the device offers."""
        return self.slave.profile.rpdo_types

    def listen(self) -> Listening:
        """Its own frames, and SYNC if they wait for it."""
        self._slices, self._length = [], 0
        self._waits_for_sync = self.transmission_type in SYNCHRONOUS
        if self.cob_id is None or not self._waits_for_sync:
            self._latched = None
        if self.cob_id is None:
            return
        for entry, size, part in self.parts():
            if entry is not None:
                self._slices.append((entry, part))
            self._length += size
        yield (self.cob_id, False), self.on_data
        if self._waits_for_sync:
            yield (self.sync_id, False), self.on_sync

    def on_state(self, state: State) -> None:
        """What waits for a SYNC is forgotten with the PDO communication."""
        self._latched = None

    def on_data(self, frame: Frame) -> None:
        """Take the data over, or keep them for SYNC; a frame that is too short is not processed."""
        if len(frame.data) < self._length:
            reason = f"{len(frame.data)} bytes, {self._length} are mapped"
            self._tell(self.number, Rejected(reason, Abort.TOO_SHORT))
        elif self._waits_for_sync:
            self._latched = frame.data
        else:
            self._take(frame.data)

    def on_sync(self, frame: Frame) -> None:
        """Take the last data over, once."""
        data, self._latched = self._latched, None
        if data is not None:
            self._take(data)

    def _take(self, data: bytes) -> None:
        for entry, part in self._slices:
            try:
                self.slave.write(entry, data[part])
            except Rejected as refusal:
                frame = Frame(self.cob_id or 0, data)
                self.slave.wire.events.add_refusal(frame, refusal, entry.address)
                self._tell(self.number, refusal)


INHIBIT_TIME, EVENT_TIMER = 3, 5  # sub-indices


class EventTiming:
    """Follows the two times of a communication record (CiA 301, 7.5.2.37).

    `due` is called when the event timer has run down, or at the end of the inhibit time if it has
    run down before that.
    """

    def __init__(self, slave: Slave, record: int, due: Callable[[], None]) -> None:
        self._slave = slave
        self._record = record
        self._due = due
        self._event_timer: Timer | None = None
        self._inhibit: Timer | None = None
        self._overdue = False

    def objects(self, exists: Callable[[], bool]) -> Mapping[Address, Object]:
        """Rules for changing the times of a PDO, given whether it exists at that moment."""

        def check_inhibit(value: int) -> None:
            if exists() and value != self._time(INHIBIT_TIME):
                raise Rejected("the inhibit time changes while the PDO is off")

        writes: Mapping[int, Callable[[int], None]] = {
            INHIBIT_TIME: check_inhibit,
            EVENT_TIMER: lambda _: self._stop_event_timer(),  # it starts with the new time
        }
        has = [sub for sub in writes if self._slave.has(self._record, sub)]
        return {(self._record, sub): Object(write=writes[sub]) for sub in has}

    @property
    def inhibited(self) -> bool:
        """Whether it is too early for the next transmission."""
        return self._inhibit is not None

    def sent(self) -> None:
        """Both times count from here."""
        self._stop_event_timer()
        self.run()
        self._overdue = False
        if time := self._time(INHIBIT_TIME):
            self._inhibit = self._slave.clock.after(time / 10_000, self._on_free)

    def run(self) -> None:
        """Run the event timer, unless it runs already."""
        if self._event_timer is None and (time := self._time(EVENT_TIMER)):
            self._event_timer = self._slave.clock.after(time / 1000, self._on_due)

    def stop(self) -> None:
        """Neither may nor must anything be sent."""
        self._stop_event_timer()
        if self._inhibit is not None:
            self._inhibit.cancel()
            self._inhibit = None

    def _stop_event_timer(self) -> None:
        if self._event_timer is not None:
            self._event_timer.cancel()
            self._event_timer = None

    def _on_due(self) -> None:
        if self.inhibited:
            self._overdue = True
        else:
            self._due()

    def _on_free(self) -> None:
        self._inhibit = None
        if self._overdue:
            self._due()

    def _time(self, subindex: int) -> int:
        has = self._slave.has(self._record, subindex)
        return self._slave.number(self._record, subindex) if has else 0


AFTER_EVENT = 0
COMPOSED_AT_SYNC = 252
AT_SYNC = frozenset({*SYNCHRONOUS, COMPOSED_AT_SYNC})
EVENT_DRIVEN = range(254, 256)


class Tpdo(Pdo):
    """Sends its objects' values of the moment its transmission type says."""

    communication, mapping, sent = 0x1800, 0x1A00, True

    def __init__(self, slave: Slave, number: int) -> None:
        super().__init__(slave, number)
        self._timing = EventTiming(slave, self.record, self.transmit)
        self._operational = False
        self._reads: list[Callable[[], bytes]] = []  # of the entries it carries
        self._cob_id = 0
        self._type = 0
        self._syncs = 0
        self._composed: bytes | None = None  # at the last SYNC or sending
        self._sent: bytes | None = None

    @property
    def types(self) -> Container[int]:
        """Transmission types the device offers."""
        return self.slave.profile.tpdo_types

    @property
    def objects(self) -> Mapping[Address, Object]:
        """As for every PDO; a written transmission type counts SYNCs from there."""
        return {
            **super().objects,
            (self.record, TRANSMISSION_TYPE): Object(write=self._set_type),
            **self._timing.objects(exists=lambda: self.cob_id is not None),
        }

    @property
    def eventful(self) -> bool:
        """Whether a change of its content sends it."""
        on_change = self.slave.profile.tpdo_on_change and self._type in EVENT_DRIVEN
        return on_change and bool(self._reads)

    def listen(self) -> Listening:
        """SYNC and remote requests, as far as its type and COB-ID know them."""
        cob_id = self.cob_id
        if cob_id is None:
            self._begin_anew()
        parts = self.parts() if cob_id is not None else []
        self._reads = [part.entry.read for part in parts if part.entry is not None]
        self._type = self.transmission_type
        self._cob_id = cob_id or 0
        self._follow_timing()
        if not self._reads:
            return
        if self._type in AT_SYNC:
            yield (self.sync_id, False), self.on_sync
        if not self.slave.number(self.record, COB_ID) & identifiers.NO_RTR:
            yield (self._cob_id, True), self.on_remote_request

    def on_state(self, state: State) -> None:
        """PDO communication begins: SYNCs count from here, event-driven ones are sent once."""
        self._operational = state is State.OPERATIONAL
        self._begin_anew()
        if self._operational and self._reads and self._type in EVENT_DRIVEN:
            self.transmit()

    def on_sync(self, frame: Frame) -> None:
        """Compose; send if it is the turn."""
        if self._type == COMPOSED_AT_SYNC:
            self._composed = self._compose()
        elif self._type == AFTER_EVENT:
            if self._compose() != self._sent:
                self.transmit()
        else:
            self._syncs += 1
            if self._syncs % self._type == 0:
                self.transmit()

    def on_remote_request(self, frame: Frame) -> None:
        """Send what was composed last, or what is there now if SYNC has no part in it."""
        if self._composed is None or self._type not in AT_SYNC:
            self._composed = self._compose()
        self.slave.send(Frame(self._cob_id, self._composed))

    def publish(self) -> None:
        """Send a change, as soon as the inhibit time allows."""
        if not self._timing.inhibited and self._compose() != self._sent:
            self.transmit()

    def transmit(self) -> None:
        """Send what there is at this moment, whatever its transmission type."""
        self._composed = self._sent = self._compose()
        self.slave.send(Frame(self._cob_id, self._sent))
        if self._type in EVENT_DRIVEN:
            self._timing.sent()

    def _begin_anew(self) -> None:
        self._syncs = 0
        self._composed = self._sent = None

    def _compose(self) -> bytes:
        return b"".join([read() for read in self._reads])

    def _follow_timing(self) -> None:
        if self._operational and self._reads and self._type in EVENT_DRIVEN:
            self._timing.run()
        else:
            self._timing.stop()

    def _set_type(self, value: int) -> None:
        self._check_type(value)
        self._syncs = 0
        self._composed = None
