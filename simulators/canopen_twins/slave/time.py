"""TIME (CiA 301, 7.2.6): the time of day that a node hears, keeps and sends, and 0x1013."""

import struct
from collections.abc import Mapping

from canopen.objectdictionary.datatypes import UNSIGNED32

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.service import Listening, Service, State, check_cob_id
from canopen_twins.slave.slave import Slave

COB_ID, STAMP = 0x1012, 0x1013
CONSUMES, PRODUCES = 1 << 31, 1 << 30
TIME_OF_DAY = struct.Struct("<LH")  # milliseconds after midnight, days since 1984-01-01 (7.1.6.5)
MILLISECONDS = (1 << 28) - 1  # the four bits above them are reserved
DAY = 86_400_000  # milliseconds
DAYS = 1 << 16
STAMPS = 1 << 32


class Time(Service):
    """A clock of days and milliseconds, right once TIME has come; before, it counts from 1984.

    For how often TIME is sent there is no object: see `Profile.time_period`.
    """

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self._may_send = False
        self._timer: Timer | None = None
        self._ahead = 0  # milliseconds, of the node's own clock
        self._stamp_ahead = 0  # microseconds

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The COB-ID, and the high resolution time stamp, which counts on from what is written."""
        has = {
            COB_ID: Object(write=self._check),
            STAMP: Object(read=lambda: self.stamp, write=self._set_stamp),
        }
        served = [index for index in has if self.slave.has(index)]
        return {(index, 0): has[index] for index in served if self._is_number(index)}

    @property
    def now(self) -> int:
        """Milliseconds since 1984-01-01."""
        return (self._elapsed // 1000 + self._ahead) % (DAYS * DAY)

    @property
    def stamp(self) -> int:
        """0x1013: microseconds, 32 bits of them."""
        return (self._elapsed + self._stamp_ahead) % STAMPS

    def listen(self) -> Listening:
        """TIME if it is consumed; it is sent if it is produced."""
        cob_id = self.slave.number(COB_ID) if self.slave.has(COB_ID) else 0
        produces = self._may_send and bool(cob_id & PRODUCES)
        if produces and self._timer is None:
            self._timer = self.slave.clock.every(self.slave.profile.time_period, self._send)
        elif not produces and self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if cob_id & CONSUMES:
            yield (cob_id & identifiers.CAN_ID, False), self.on_time

    def on_state(self, state: State) -> None:
        """TIME is sent in Pre-operational and Operational."""
        self._may_send = state in self.active_in

    def on_time(self, frame: Frame) -> None:
        """Set the clock; what has not six bytes is no time."""
        if len(frame.data) == TIME_OF_DAY.size:
            milliseconds, days = TIME_OF_DAY.unpack(frame.data)
            self._ahead += days * DAY + (milliseconds & MILLISECONDS) - self.now

    def _is_number(self, index: int) -> bool:
        return self.slave.entries[index][0].variable.data_type == UNSIGNED32

    @property
    def _elapsed(self) -> int:
        return microseconds(self.slave.clock.now)

    def _send(self) -> None:
        days, milliseconds = divmod(self.now, DAY)
        can_id = self.slave.number(COB_ID) & identifiers.CAN_ID
        self.slave.send(Frame(can_id, TIME_OF_DAY.pack(milliseconds, days)))

    def _check(self, value: int) -> None:
        before = self.slave.number(COB_ID)
        if before & PRODUCES and (before ^ value) & identifiers.CAN_ID:
            raise Rejected("bit 30 has to be cleared before the identifier changes")
        check_cob_id(value & ~(PRODUCES | CONSUMES))

    def _set_stamp(self, value: int) -> None:
        self._stamp_ahead += value - self.stamp
