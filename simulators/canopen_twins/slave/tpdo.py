"""TPDOs: when they are sent, by SYNC, by an event, or on request (CiA 301, 7.2.2)."""

from collections.abc import Callable, Container, Mapping
from functools import partial

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.pdo import (
    COB_ID,
    EVENT_DRIVEN,
    SYNCHRONOUS,
    TRANSMISSION_TYPE,
    Mapped,
    Pdo,
    packed,
)
from canopen_twins.slave.service import Listening, State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.sync import OVERFLOW, at_sync
from canopen_twins.slave.sync import number as sync_number

INHIBIT_TIME, EVENT_TIMER, SYNC_START = 3, 5, 6  # sub-indices
AFTER_EVENT = 0
COMPOSED_AT_SYNC = 252
AT_SYNC = frozenset({*SYNCHRONOUS, COMPOSED_AT_SYNC})


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
            self._event_timer = self._slave.clock.after_period(time / 1000, self._on_due)

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


class Tpdo(Pdo):
    """Sends its objects' values of the moment its transmission type says."""

    communication, mapping, sent = 0x1800, 0x1A00, True

    def __init__(self, slave: Slave, number: int) -> None:
        super().__init__(slave, number)
        self._timing = EventTiming(slave, self.record, self.transmit)
        self._operational = False
        self._compose: Callable[[], bytes] = bytes
        self._carries = False
        self._cob_id = 0
        self._type = 0
        self._syncs = 0
        self._start = 0  # counter of the SYNC that is counted first, 0 for any
        self._started = False
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
            **self._bound(
                {
                    TRANSMISSION_TYPE: Object(write=self._set_type),
                    SYNC_START: Object(write=self._check_start),
                }
            ),
            **self._timing.objects(exists=lambda: self.cob_id is not None),
        }

    @property
    def eventful(self) -> bool:
        """Whether a change of its content sends it."""
        on_change = self.slave.profile.tpdo_on_change and self._type in EVENT_DRIVEN
        return on_change and self._carries

    def listen(self) -> Listening:
        """SYNC and remote requests, as far as its type and COB-ID know them."""
        parts, cob_id = self.parts(), self.cob_id
        if cob_id is None:
            self._begin_anew()
        self._carries, self._compose = bool(parts), _composing(parts)
        self._type = self.transmission_type
        self._cob_id = cob_id or 0
        self._start = self._setting(SYNC_START) if sync_number(self.slave, OVERFLOW) else 0
        self._follow_timing()
        if not parts:
            return
        if self._type in AT_SYNC:
            yield from at_sync(self.slave, self.on_sync)
        if not self.slave.number(self.record, COB_ID) & identifiers.NO_RTR:
            yield (self._cob_id, True), self.on_remote_request

    def on_state(self, state: State) -> None:
        """PDO communication begins: SYNCs count from here, event-driven ones are sent once."""
        self._operational = state is State.OPERATIONAL
        self._begin_anew()
        if self._operational and self._carries and self._type in EVENT_DRIVEN:
            self.transmit()

    def on_sync(self, frame: Frame) -> bool:
        """Compose; send if it is the turn."""
        if self._type == COMPOSED_AT_SYNC:
            self._composed = self._compose()
        elif self._type == AFTER_EVENT:
            if self._compose() != self._sent:
                self.transmit()
        elif self._started or not self._start or frame.data[0] == self._start:
            self._started = True
            self._syncs += 1
            if self._syncs % self._type == 0:
                self.transmit()
        return True

    def on_remote_request(self, frame: Frame) -> bool:
        """Send what was composed last, or what is there now if SYNC has no part in it."""
        if self._composed is None or self._type not in AT_SYNC:
            self._composed = self._compose()
        self.slave.send(Frame(self._cob_id, self._composed))
        return True

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
        self._syncs, self._started = 0, False
        self._composed = self._sent = None

    def _follow_timing(self) -> None:
        if self._operational and self._carries and self._type in EVENT_DRIVEN:
            self._timing.run()
        else:
            self._timing.stop()

    def _set_type(self, value: int) -> None:
        self._check_type(value)
        self._syncs, self._started = 0, False
        self._composed = None

    def _check_start(self, value: int) -> None:
        if self.cob_id is not None and value != self._setting(SYNC_START):
            raise Rejected("the SYNC start value changes while the PDO is off")


def _composing(parts: list[Mapped]) -> Callable[[], bytes]:
    """What makes data of the values of the moment: quickly where whole objects are mapped."""
    reads = [
        part.entry.read
        for part in parts
        if part.entry is not None and part.entry.size is not None and part.whole is not None
    ]
    if len(reads) == len(parts):
        return lambda: b"".join([read() for read in reads])
    return partial(packed, parts)
