"""What a PDO carries: the mapping as the dictionary has it, and the rules for changing it."""

from collections.abc import Callable, Container, Iterator, Mapping
from functools import partial
from typing import NamedTuple

from canopen_twins.slave import cob_id as cob_ids
from canopen_twins.slave.dictionary import DUMMIES
from canopen_twins.slave.object import Abort, Address, Entry, Object, Rejected
from canopen_twins.slave.service import Service, State
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
        entry = None if value >> 16 in DUMMIES else slave.entry(value >> 16, value >> 8 & 0xFF)
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


class MappingRules:
    """The procedure of CiA 301, 7.5.2.36: PDO off, count 0, entries, count."""

    def __init__(self, slave: Slave, index: int, may_change: Callable[[], bool], sent: bool):
        self.slave = slave
        self.index = index
        self._may_change = may_change
        self._sent = sent

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Checks for every entry of the record that the EDS lets be written."""
        entries = self.slave.entries[self.index]
        checks = {sub: partial(self._check_entry, sub) for sub in entries if sub}
        return {
            (self.index, sub): Object(write=checks.get(sub, self._check_count))
            for sub, entry in entries.items()
            if entry.writable
        }

    def _check_off(self) -> None:
        if not self._may_change():
            raise Rejected("a mapping changes while its PDO is off", Abort.DEVICE_STATE)

    def _check_entry(self, subindex: int, value: int) -> None:
        self._check_off()
        if self.slave.number(self.index):
            raise Rejected("a mapping changes while its count is 0", Abort.DEVICE_STATE)
        if value:
            self._check_mappable(value)

    def _check_count(self, count: int) -> None:
        self._check_off()
        values = [self.slave.number(self.index, sub) for sub in self._subindices(count)]
        for value in values:
            self._check_mappable(value)
        if sum(value & 0xFF for value in values) > LONGEST:
            raise Rejected("a PDO carries 64 bits", Abort.PDO_TOO_LONG)

    def _subindices(self, count: int) -> range:
        if count >= len(self.slave.entries[self.index]):
            raise Rejected("more parts than the record has", Abort.PDO_TOO_LONG)
        return range(1, count + 1)

    def _check_mappable(self, value: int) -> None:
        index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & 0xFF
        if not self._sent and subindex == 0 and self.slave.dummies.get(index) == bits:
            return
        entry = self.slave.entry(index, subindex)
        fits = entry.size is not None and entry.size * BYTE == bits
        may = entry.variable.access_type in (CAN_BE_SENT if self._sent else CAN_BE_RECEIVED)
        if not (entry.variable.pdo_mappable and fits and may):
            raise Rejected(f"{value:08X}h cannot be mapped", Abort.NOT_MAPPABLE)


COB_ID, TRANSMISSION_TYPE = 1, 2  # sub-indices
SYNCHRONOUS = range(241)
PDO_COUNT = 512
DEFAULT_SYNC = 0x80


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
        self._rules = MappingRules(slave, self.mapping + number - 1, self._is_off, self.sent)
        # RPDO: bit 30 is of no use there and stays as the EDS has it; strict: it has to be right
        self._fixed = 0 if self.sent else slave.number(self.record, COB_ID) & cob_ids.NO_RTR
        self._adjust = None if slave.profile.strict_cob_id else self._adjust_cob_id

    @classmethod
    def numbers(cls, slave: Slave) -> Iterator[int]:
        """The PDOs of this kind that the dictionary has."""
        return (n + 1 for n in range(PDO_COUNT) if cls.communication + n in slave.entries)

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
            **self._rules.objects,
        }

    @property
    def cob_id(self) -> int | None:
        """The identifier the PDO uses, none while it is off."""
        value = self.slave.number(self.record, COB_ID)
        return None if value & cob_ids.INVALID else value & cob_ids.CAN_ID

    @property
    def transmission_type(self) -> int:
        """When data are taken over or sent (CiA 301, tables 70 and 72)."""
        return self.slave.number(self.record, TRANSMISSION_TYPE)

    @property
    def sync_id(self) -> int:
        """The identifier of the SYNC message."""
        value = self.slave.number(0x1005) if self.slave.has(0x1005) else DEFAULT_SYNC
        return value & cob_ids.CAN_ID

    def parts(self) -> list[Mapped]:
        """What the PDO carries at this moment."""
        return mapped(self.slave, self._rules.index)

    def _is_off(self) -> bool:
        return self.cob_id is None

    def _adjust_cob_id(self, value: int) -> int:
        return value & ~cob_ids.NO_RTR | self._fixed if self._fixed else value

    def _check_cob_id(self, value: int) -> None:
        before = self.slave.number(self.record, COB_ID)
        if self._fixed & ~value:
            raise Rejected("bit 30 of this RPDO is always 1")
        cob_ids.check_change(before, value, strict=self.slave.profile.strict_cob_id)

    def _check_type(self, value: int) -> None:
        if value not in self.types:
            raise Rejected(f"no transmission type {value} here")
