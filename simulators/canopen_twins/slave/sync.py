"""SYNC (CiA 301, 7.2.5): its identifier, its counter, and sending it."""

from collections.abc import Callable, Mapping

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import MICROSECONDS, Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.service import Handler, Listening, Service, State, check_cob_id
from canopen_twins.slave.slave import Slave

COB_ID, PERIOD, WINDOW, OVERFLOW = 0x1005, 0x1006, 0x1007, 0x1019
COUNTERS = range(2, 241)  # values of 0x1019 with which SYNC carries a counter
WRONG_LENGTH = "SYNC is not as long as 0x1019 says"


def number(slave: Slave, index: int) -> int:
    """The value of an object of SYNC, 0 if there is none."""
    return slave.number(index) if slave.has(index) else 0


def sync_id(slave: Slave) -> int:
    """The identifier of the SYNC message."""
    return number(slave, COB_ID) & identifiers.CAN_ID if slave.has(COB_ID) else identifiers.SYNC


def at_sync(slave: Slave, handle: Handler) -> Listening:
    """What a synchronous PDO hears: SYNC of any length, or of that which 0x1019 asks for."""
    if not slave.has(OVERFLOW):
        yield (sync_id(slave), False), handle
        return
    length = 1 if slave.number(OVERFLOW) else 0

    def of_right_length(frame: Frame) -> bool | None:
        return handle(frame) if len(frame.data) == length else True

    yield (sync_id(slave), False), of_right_length


class Sync(Service):
    """Which identifier starts synchronous PDOs, which hear it themselves; and its producer.

    Without 0x1006 this node cannot produce SYNC. A counter begins with 1 whenever production does.
    """

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self._may_send = False
        self._running = 0  # period in microseconds, 0 while none is sent
        self._timer: Timer | None = None
        self._counter = 0  # the last that was sent

    @property
    def objects(self) -> Mapping[Address, Object]:
        """What is written acts at once."""
        checks: Mapping[int, Callable[[int], None]] = {
            COB_ID: self._check,
            OVERFLOW: self._check_overflow,
        }
        return {
            (index, 0): Object(write=check)
            for index, check in checks.items()
            if self.slave.has(index)
        }

    def listen(self) -> Listening:
        """Produce as the dictionary says; SYNC is heard only to complain of its length."""
        period = number(self.slave, PERIOD) if self._may_send and self._produces else 0
        if period != self._running:
            self._produce(period)
        if self.slave.has(OVERFLOW):
            yield (sync_id(self.slave), False), self.on_sync

    def on_state(self, state: State) -> None:
        """SYNC is sent in Pre-operational and Operational."""
        self._may_send = state in self.active_in

    def on_sync(self, frame: Frame) -> bool:
        """One that is too long or too short is an error until the next that is not."""
        expected = 1 if self.slave.number(OVERFLOW) else 0
        if len(frame.data) != expected:
            self.slave.errors[WRONG_LENGTH] = 0x8240
            return False
        return self.slave.errors.pop(WRONG_LENGTH, None) is None

    @property
    def _produces(self) -> bool:
        return bool(number(self.slave, COB_ID) & identifiers.PRODUCES)

    def _produce(self, period: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._running, self._timer, self._counter = period, None, 0
        if period:
            self._timer = self.slave.clock.every(period / MICROSECONDS, self._send)

    def _send(self) -> None:
        data, overflow = b"", number(self.slave, OVERFLOW)
        if overflow:
            self._counter = self._counter % overflow + 1
            data = bytes([self._counter])
        frame = Frame(sync_id(self.slave), data)
        self.slave.send(frame)
        self.slave.hear(frame)

    def _check(self, value: int) -> None:
        if value & identifiers.PRODUCES and not self.slave.has(PERIOD):
            raise Rejected("this node does not produce SYNC")
        if value & identifiers.INVALID:
            raise Rejected(f"{value:08X}h: bit 31 is always 0")
        if self._produces and (value ^ self.slave.number(COB_ID)) & ~identifiers.PRODUCES:
            raise Rejected("bit 30 has to be cleared before the identifier changes")
        check_cob_id(value & ~identifiers.PRODUCES)

    def _check_overflow(self, value: int) -> None:
        if value and value not in COUNTERS:
            raise Rejected(f"a counter runs to 2..240, or there is none: {value}")
        if number(self.slave, PERIOD):
            raise Rejected("0x1006 has to be 0 before the counter changes", Abort.DEVICE_STATE)
