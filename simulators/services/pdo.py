"""What RPDO and TPDO have in common: the communication record and the rules for changing it."""

from collections.abc import Container, Iterator, Mapping

from simulators.objects import Address, Object, Rejected
from simulators.services import Service, State
from simulators.services import cob_id as cob_ids
from simulators.services.mapping import Mapped, MappingRules, mapped
from simulators.slave import Slave

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
