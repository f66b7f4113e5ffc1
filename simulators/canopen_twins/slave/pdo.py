"""PDOs that follow 0x1400..0x1BFF as the dictionary has them at that moment: what they carry.

Parts of a PDO follow each other without gaps, the lowest bit of the first byte first (CiA 301,
7.2.2.7 and 7.5.2.36). Here are the rules for changing that; `rpdo` and `tpdo` say when data are
taken over or sent.
"""

from collections.abc import Container, Iterable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

from canopen.objectdictionary.datatypes import DOMAIN, INTEGER_TYPES, UNSIGNED32

from canopen_twins.bus import identifiers
from canopen_twins.slave.object import DUMMY_TYPES, Abort, Address, Entry, Object, Rejected
from canopen_twins.slave.service import Service, State, check_cob_id_change
from canopen_twins.slave.slave import Slave

LONGEST = 64  # bits of a PDO
BYTE = 8
BITS = 0x7F  # of a length; some tools set the bit above
MPDO = range(0xFE, 0x100)  # counts that stand for a multiplexed PDO, which there is none of
CAN_BE_SENT = frozenset({"ro", "const", "rw", "rwr"})  # access types (CiA 306)
CAN_BE_RECEIVED = frozenset({"wo", "rw", "rww"})


class Mapped(NamedTuple):
    """One part of a PDO; a dummy has no entry and only fills the room."""

    entry: Entry | None
    bits: int
    begin: int
    """Its first bit in the PDO."""

    @property
    def end(self) -> int:
        """The bit behind its last."""
        return self.begin + self.bits

    @property
    def whole(self) -> slice | None:
        """Its bytes in the PDO; none if it is a part of its object, or begins within a byte."""
        size = None if self.entry is None else self.entry.size
        if self.begin % BYTE or self.bits % BYTE or size not in {None, self.bits // BYTE}:
            return None
        return slice(self.begin // BYTE, self.end // BYTE)

    def value(self, data: bytes) -> bytes:
        """What the data of a PDO bring for its object; zeros stand above a part of it."""
        if (part := self.whole) is not None:
            return data[part]
        bits = int.from_bytes(data, "little") >> self.begin & (1 << self.bits) - 1
        size = None if self.entry is None else self.entry.size
        size = bytes_of(self.bits) if size is None else size
        return (bits & (1 << size * BYTE) - 1).to_bytes(size, "little")


def bytes_of(bits: int) -> int:
    """How many bytes hold so many bits."""
    return -(-bits // BYTE)


def length(parts: list[Mapped]) -> int:
    """The bytes of a PDO."""
    return bytes_of(parts[-1].end) if parts else 0


def packed(parts: list[Mapped]) -> bytes:
    """The values of this moment as a PDO carries them: the low bits of each."""
    bits = 0
    for part in parts:
        if part.entry is not None:
            value = int.from_bytes(part.entry.read(), "little")
            bits |= (value & (1 << part.bits) - 1) << part.begin
    return bits.to_bytes(length(parts), "little")


def mapped(slave: Slave, index: int) -> list[Mapped]:
    """The parts of a PDO in their order, from the mapping record at an index.

    An entry of 0 takes no room.

    Raises:
        Rejected: the mapping names an object that does not exist, is longer than a frame, or is
            that of an MPDO.
    """
    parts: list[Mapped] = []
    begin, count = 0, slave.number(index)
    if count in MPDO:
        raise Rejected("a multiplexed PDO, which this node has none of")
    for subindex in range(1, count + 1):
        slave.entry(index, subindex)  # a record may have gaps
        if not (value := slave.number(index, subindex)):
            continue
        if not value & BITS:
            raise Rejected(f"{value:08X}h has no length", Abort.NOT_MAPPABLE)
        entry = None if value >> 16 in DUMMY_TYPES else slave.entry(value >> 16, value >> 8 & 0xFF)
        parts.append(Mapped(entry, value & BITS, begin))
        begin += value & BITS
    if begin > LONGEST:
        raise Rejected("a PDO carries 64 bits", Abort.PDO_TOO_LONG)
    return parts


def carried(slave: Slave, index: int) -> list[Mapped]:
    """The same for whoever only looks: nothing if the mapping is not valid."""
    try:
        return mapped(slave, index)
    except Rejected:
        return []


COB_ID, TRANSMISSION_TYPE = 1, 2  # sub-indices
SYNCHRONOUS = range(241)
EVENT_DRIVEN = range(254, 256)
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
        self._begun = False

    @classmethod
    def numbers(cls, slave: Slave) -> Iterator[int]:
        """The PDOs of this kind that the dictionary has; each has both of its records."""
        records = range(cls.communication, cls.communication + PDO_COUNT)
        found = sorted(records.index(index) for index in slave.entries if index in records)
        return (n + 1 for n in found if cls._has(slave, n))

    @classmethod
    def _has(cls, slave: Slave, place: int) -> bool:
        record = slave.entries[cls.communication + place]
        mapping = slave.entries.get(cls.mapping + place, {})
        if COB_ID not in record or 0 not in mapping:
            return False
        return record[COB_ID].variable.data_type == UNSIGNED32 and _are_numbers(mapping.values())

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
            **self._bound({TRANSMISSION_TYPE: Object(write=self._check_type)}),
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
        has = self.slave.has(self.record, TRANSMISSION_TYPE)
        return self.slave.number(self.record, TRANSMISSION_TYPE) if has else EVENT_DRIVEN[-1]

    def parts(self) -> list[Mapped]:
        """What the PDO carries at this moment: nothing while it is off.

        One whose file maps what is not there is off from the beginning.
        """
        if self._begun and self.cob_id is None:
            return []
        try:
            parts = mapped(self.slave, self._mapping)
        except Rejected:
            parts = []
            if not self._begun:
                self._switch_off()
        self._begun = True
        return parts if self.cob_id is not None else []

    def _switch_off(self) -> None:
        entry = self.slave.entry(self.record, COB_ID)
        off = self.slave.number(self.record, COB_ID) | identifiers.INVALID
        self.slave.data_store[self.record][COB_ID] = entry.pack(off)

    def _bound(self, acts: Mapping[int, Object]) -> Mapping[Address, Object]:
        """Those of its communication record that the dictionary has."""
        has = [subindex for subindex in acts if self.slave.has(self.record, subindex)]
        return {(self.record, subindex): acts[subindex] for subindex in has}

    def _setting(self, subindex: int) -> int:
        """The value of an entry of its communication record, 0 if there is none."""
        has = self.slave.has(self.record, subindex)
        return self.slave.number(self.record, subindex) if has else 0

    def _adjust_cob_id(self, value: int) -> int:
        return value & ~identifiers.NO_RTR | self._fixed if self._fixed else value

    def _check_cob_id(self, value: int) -> None:
        if self._fixed & ~value:
            raise Rejected("bit 30 of this RPDO is always 1")
        before = self.slave.number(self.record, COB_ID)
        check_cob_id_change(before, value, strict=self.slave.profile.strict_cob_id)
        if before & identifiers.INVALID and not value & identifiers.INVALID:
            self._check_mapping_as_it_is()

    def _check_mapping_as_it_is(self) -> None:
        """A PDO can only come into being with a mapping, unless it has none for good."""
        try:
            parts = mapped(self.slave, self._mapping)
        except Rejected as refusal:
            raise Rejected(f"its mapping is not valid: {refusal}") from refusal
        if not parts and self.slave.entry(self._mapping, 0).writable:
            raise Rejected("nothing is mapped")

    def _check_type(self, value: int) -> None:
        if value not in self.types:
            raise Rejected(f"no transmission type {value} here")

    def _check_mapping(self, subindex: int, value: int) -> None:
        """The procedure of CiA 301, 7.5.2.36: PDO off, count 0, entries, count."""
        if self.cob_id is not None:
            raise Rejected("a mapping changes while its PDO is off", Abort.ACCESS)
        if not subindex:
            self._check_count(value)
        elif self.slave.number(self._mapping):
            raise Rejected("a mapping changes while its count is 0", Abort.ACCESS)
        elif value:
            self._check_mappable(value)

    def _check_count(self, count: int) -> None:
        if count in MPDO:
            raise Rejected("a multiplexed PDO, which this node has none of")
        if count > max(self.slave.entries[self._mapping]):
            raise Rejected("more parts than the record has", Abort.PDO_TOO_LONG)
        for subindex in range(1, count + 1):
            self.slave.entry(self._mapping, subindex)  # a record may have gaps
        values = [self.slave.number(self._mapping, sub) for sub in range(1, count + 1)]
        for value in filter(None, values):
            self._check_mappable(value)
        if sum(value & BITS for value in values) > LONGEST:
            raise Rejected("a PDO carries 64 bits", Abort.PDO_TOO_LONG)

    def _check_mappable(self, value: int) -> None:
        index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & BITS
        if index in DUMMY_TYPES:
            self._check_dummy(value)
            return
        entry = self.slave.entry(index, subindex)
        may = entry.variable.access_type in (CAN_BE_SENT if self.sent else CAN_BE_RECEIVED)
        if not (entry.variable.pdo_mappable and may and bits in _lengths(entry)):
            raise Rejected(f"{value:08X}h cannot be mapped", Abort.NOT_MAPPABLE)

    def _check_dummy(self, value: int) -> None:
        index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & BITS
        if self.sent or subindex or index not in self.slave.dummies:
            raise Rejected(f"{value:08X}h is no dummy here", Abort.NO_OBJECT)
        if not 1 <= bits <= self.slave.dummies[index]:
            raise Rejected(f"{value:08X}h is longer than its type", Abort.NOT_MAPPABLE)


def _are_numbers(entries: Iterable[Entry]) -> bool:
    return all(entry.variable.data_type in INTEGER_TYPES for entry in entries)


def _lengths(entry: Entry) -> range:
    """The bits of an entry that a PDO may carry: of a text whole bytes, of a domain none."""
    if entry.size is not None:
        return range(1, entry.size * BYTE + 1)
    return range(0) if entry.variable.data_type == DOMAIN else range(BYTE, LONGEST + 1, BYTE)
