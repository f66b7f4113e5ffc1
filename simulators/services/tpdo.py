"""Transmit PDO: composed from the dictionary, sent on SYNC, on request, on change, on a timer."""

from collections.abc import Container, Mapping

from simulators.entry import Entry
from simulators.frame import Frame
from simulators.objects import Address, Object
from simulators.services import Listening, State
from simulators.services import cob_id as cob_ids
from simulators.services.event_timing import EventTiming
from simulators.services.pdo import COB_ID, SYNCHRONOUS, TRANSMISSION_TYPE, Pdo
from simulators.slave import Slave

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
        self._entries: list[Entry] = []
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
        return on_change and bool(self._entries)

    def listen(self) -> Listening:
        """SYNC and remote requests, as far as its type and COB-ID know them."""
        cob_id = self.cob_id
        if cob_id is None:
            self._begin_anew()
        parts = self.parts() if cob_id is not None else []
        self._entries = [entry for entry, _ in parts if entry is not None]
        self._type = self.transmission_type
        self._cob_id = cob_id or 0
        self._follow_timing()
        if not self._entries:
            return
        if self._type in AT_SYNC:
            yield (self.sync_id, False), self.on_sync
        if not self.slave.number(self.record, COB_ID) & cob_ids.NO_RTR:
            yield (self._cob_id, True), self.on_remote_request

    def on_state(self, state: State) -> None:
        """PDO communication begins: SYNCs count from here, event-driven ones are sent once."""
        self._operational = state is State.OPERATIONAL
        self._begin_anew()
        if self._operational and self._entries and self._type in EVENT_DRIVEN:
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
        self.slave.wire.put(Frame(self._cob_id, self._composed))

    def publish(self) -> None:
        """Send a change, as soon as the inhibit time allows."""
        if not self._timing.inhibited and self._compose() != self._sent:
            self.transmit()

    def transmit(self) -> None:
        """Send what there is at this moment, whatever its transmission type."""
        self._composed = self._sent = self._compose()
        self.slave.wire.put(Frame(self._cob_id, self._sent))
        if self._type in EVENT_DRIVEN:
            self._timing.sent()

    def _begin_anew(self) -> None:
        self._syncs = 0
        self._composed = self._sent = None

    def _compose(self) -> bytes:
        return b"".join([entry.read() for entry in self._entries])

    def _follow_timing(self) -> None:
        if self._operational and self._entries and self._type in EVENT_DRIVEN:
            self._timing.run()
        else:
            self._timing.stop()

    def _set_type(self, value: int) -> None:
        self._check_type(value)
        self._syncs = 0
        self._composed = None
