"""Receive PDO: frames whose data go into the dictionary, at once or at the next SYNC."""

from collections.abc import Callable, Container

from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Abort, Entry, Rejected
from canopen_twins.slave.pdo import SYNCHRONOUS, Pdo
from canopen_twins.slave.service import Listening, State
from canopen_twins.slave.slave import Slave


class Rpdo(Pdo):
    """Hands the values to their objects; what is refused, `tell` hears of with its number."""

    communication, mapping, sent = 0x1400, 0x1600, False

    def __init__(self, slave: Slave, number: int, tell: Callable[[int, Rejected], None]) -> None:
        super().__init__(slave, number)
        self._tell = tell
        self._slices: list[tuple[Entry, slice]] = []
        self._length = 0
        self._waits_for_sync = False
        self._latched: bytes | None = None

    @property
    def types(self) -> Container[int]:
        """Transmission types the device offers."""
        return self.slave.profile.rpdo_types

    def listen(self) -> Listening:
        """Its own frames, and SYNC if they wait for it."""
        self._slices, self._length = [], 0
        self._waits_for_sync = self.transmission_type in SYNCHRONOUS
        if self.cob_id is None or not self._waits_for_sync:
            self._latched = None
        if self.cob_id is None:
            return
        for entry, size, part in self.parts():
            if entry is not None:
                self._slices.append((entry, part))
            self._length += size
        yield (self.cob_id, False), self.on_data
        if self._waits_for_sync:
            yield (self.sync_id, False), self.on_sync

    def on_state(self, state: State) -> None:
        """What waits for a SYNC is forgotten with the PDO communication."""
        self._latched = None

    def on_data(self, frame: Frame) -> None:
        """Take the data over, or keep them for SYNC; a frame that is too short is not processed."""
        if len(frame.data) < self._length:
            reason = f"{len(frame.data)} bytes, {self._length} are mapped"
            self._tell(self.number, Rejected(reason, Abort.TOO_SHORT))
        elif self._waits_for_sync:
            self._latched = frame.data
        else:
            self._take(frame.data)

    def on_sync(self, frame: Frame) -> None:
        """Take the last data over, once."""
        data, self._latched = self._latched, None
        if data is not None:
            self._take(data)

    def _take(self, data: bytes) -> None:
        for entry, part in self._slices:
            try:
                self.slave.write(entry, data[part])
            except Rejected as refusal:
                frame = Frame(self.cob_id or 0, data)
                self.slave.wire.diary.refuse(frame, refusal, entry.address)
                self._tell(self.number, refusal)
