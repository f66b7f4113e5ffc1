"""What a PDO carries: the mapping as the dictionary has it, and the rules for changing it."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from simulators.dictionary import DUMMIES
from simulators.entry import Entry
from simulators.objects import Abort, Address, Object, Rejected
from simulators.slave import Slave

LONGEST = 64  # bits of a PDO
BYTE = 8
CAN_BE_SENT = frozenset({"ro", "const", "rw", "rwr"})  # access types (CiA 306)
CAN_BE_RECEIVED = frozenset({"wo", "rw", "rww"})


class Mapped(NamedTuple):
    """One part of a PDO; a dummy has no entry and only fills the room."""

    entry: Entry | None
    size: int


def mapped(slave: Slave, index: int) -> list[Mapped]:
    """The parts of a PDO in their order, from the mapping record at an index.

    Raises:
        Rejected: the mapping names an object that does not exist.
    """
    return [_part(slave, slave.number(index, sub)) for sub in range(1, slave.number(index) + 1)]


def _part(slave: Slave, value: int) -> Mapped:
    index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & 0xFF
    entry = None if index in DUMMIES else slave.entry(index, subindex)
    return Mapped(entry, bits // BYTE)


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
