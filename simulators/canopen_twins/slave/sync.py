"""SYNC consumer: which identifier starts synchronous PDOs (0x1005); the PDOs hear it themselves."""

from collections.abc import Mapping

from canopen_twins.slave import cob_id as cob_ids
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.service import Service

PRODUCES = 1 << 30


class Sync(Service):
    """Consumes SYNC and never produces it."""

    @property
    def objects(self) -> Mapping[Address, Object]:
        """A new identifier acts at once."""
        return {(0x1005, 0): Object(write=self._check)} if self.slave.has(0x1005) else {}

    def _check(self, value: int) -> None:
        if value & PRODUCES:
            raise Rejected("this node does not produce SYNC")
        if value & cob_ids.INVALID:
            raise Rejected(f"{value:08X}h: bit 31 is always 0")
        cob_ids.check(value)
