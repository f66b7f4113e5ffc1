"""Transmit PDO: composed from the dictionary, sent on SYNC, on request, on change, on a timer."""

from collections.abc import Container, Mapping

from simulators.clock import Timer
from simulators.entry import Entry
from simulators.objects import Address, Object
from simulators.services import Listening, State
from simulators.services import cob_id as cob_ids
from simulators.services.pdo import (
    COB_ID,
    EVENT_TIMER,
    INHIBIT_TIME,
    SYNCHRONOUS,
    TRANSMISSION_TYPE,
    Pdo,
)
from simulators.slave import Slave
from simulators.wire import Frame

AT_SYNC_AFTER_EVENT = 0
COMPOSED_AT_SYNC, COMPOSED_ON_REQUEST = 252, 253
EVENT_DRIVEN = range(254, 256)


class Tpdo(Pdo):
    """Sends its objects' values of the moment its transmission type says."""

    communication, mapping, sent = 0x1800, 0x1A00, True

    def __init__(self, slave: Slave, number: int) -> None:
        super().__init__(slave, number)
        self._operational = False
        self._entries: list[Entry] = []
        self._cob_id = 0
        self._type = COMPOSED_ON_REQUEST
        self._syncs = 0
        self._composed: bytes | None = None  # at the last SYNC or sending
        self._sent: bytes | None = None
        self._event_timer: Timer | None = None
        self._event_time = 0
        self._inhibit: Timer | None = None

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
            **(
                {(self.record, EVENT_TIMER): Object(write=lambda _: self._stop_timer())}
                if self.slave.has(self.record, EVENT_TIMER)
                else {}
            ),
        }

    @property
    def eventful(self) -> bool:
        """Whether a change of its content means anything."""
        on_change = self.slave.profile.tpdo_on_change and self._type in EVENT_DRIVEN
        return bool(self._entries) and (on_change or self._type == AT_SYNC_AFTER_EVENT)

    def listen(self) -> Listening:
        """SYNC and remote requests, as far as its type and COB-ID know them."""
        cob_id = self.cob_id
        parts = self.parts() if cob_id is not None else []
        self._entries = [entry for entry, _ in parts if entry is not None]
        self._type = self.transmission_type
        self._cob_id = cob_id or 0
        self._follow_timer()
        if not self._entries:
            return
        if self._type in SYNCHRONOUS or self._type == COMPOSED_AT_SYNC:
            yield (self.sync_id, False), self.on_sync
        if not self.slave.number(self.record, COB_ID) & cob_ids.NO_RTR:
            yield (self._cob_id, True), self.on_remote_request

    def on_state(self, state: State) -> None:
        """PDO communication begins: SYNCs count from here, event-driven ones are sent once."""
        self._operational = state is State.OPERATIONAL
        self._syncs = 0
        self._composed = self._sent = None
        self._stop_timer()
        self._cancel_inhibit()
        if self._operational and self._entries and self._type in EVENT_DRIVEN:
            self._transmit()
        self._follow_timer()

    def on_sync(self, frame: Frame) -> None:
        """Compose; send if it is the turn."""
        if self._type == COMPOSED_AT_SYNC:
            self._composed = self._compose()
        elif self._type == AT_SYNC_AFTER_EVENT:
            if self._compose() != self._sent:
                self._transmit()
        else:
            self._syncs += 1
            if self._syncs % self._type == 0:
                self._transmit()

    def on_remote_request(self, frame: Frame) -> None:
        """Send what was composed last, or, of type 253, what is there now."""
        if self._composed is None or self._type == COMPOSED_ON_REQUEST:
            self._composed = self._compose()
        self.slave.wire.put(Frame(self._cob_id, self._composed))

    def publish(self) -> None:
        """Send a change, as soon as the inhibit time allows."""
        if self._type not in EVENT_DRIVEN or self._inhibit is not None:
            return
        if self._compose() != self._sent:
            self._transmit()
            self._stop_timer()  # the next one is due a whole period from here
            self._follow_timer()

    def _compose(self) -> bytes:
        return b"".join([entry.read() for entry in self._entries])

    def _transmit(self) -> None:
        self._composed = self._sent = self._compose()
        self.slave.wire.put(Frame(self._cob_id, self._sent))
        if self._type in EVENT_DRIVEN and (time := self._optional(INHIBIT_TIME)):
            self._cancel_inhibit()
            self._inhibit = self.slave.clock.after(time / 10_000, self._end_inhibit)

    def _end_inhibit(self) -> None:
        self._inhibit = None
        if self.eventful:
            self.publish()

    def _cancel_inhibit(self) -> None:
        if self._inhibit is not None:
            self._inhibit.cancel()
            self._inhibit = None

    def _follow_timer(self) -> None:
        """Run the event timer with the period the dictionary has, from the moment it has it."""
        wanted = self._operational and self._entries and self._type in EVENT_DRIVEN
        time = self._optional(EVENT_TIMER) if wanted else 0
        if not time:
            self._stop_timer()
        elif self._event_timer is None or time != self._event_time:
            self._stop_timer()
            self._event_time = time
            self._event_timer = self.slave.clock.every(time / 1000, self._on_timer)

    def _on_timer(self) -> None:
        if self._inhibit is None:
            self._transmit()

    def _stop_timer(self) -> None:
        if self._event_timer is not None:
            self._event_timer.cancel()
            self._event_timer = None

    def _set_type(self, value: int) -> None:
        self._check_type(value)
        self._syncs = 0

    def _optional(self, subindex: int) -> int:
        has = self.slave.has(self.record, subindex)
        return self.slave.number(self.record, subindex) if has else 0
