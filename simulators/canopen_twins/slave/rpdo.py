"""RPDOs: when what they bring is taken over, and what is wrong with it (CiA 301, 7.2.2)."""

from collections.abc import Callable, Container, Mapping
from operator import itemgetter

from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Abort, Address, Entry, Object, Rejected
from canopen_twins.slave.pdo import SYNCHRONOUS, Mapped, Pdo, length
from canopen_twins.slave.service import Listening, State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.sync import WINDOW, at_sync, number

EVENT_TIMER = 5  # sub-index
TOO_SHORT, TOO_LONG, LATE = 0x8210, 0x8220, 0x8250  # emergency error codes
WHY = {TOO_SHORT: "is shorter than its mapping", TOO_LONG: "is longer than its mapping"}
WHY[LATE] = "has not come in time"

Cut = Callable[[bytes], bytes]


class Rpdo(Pdo):
    """Hands the values to their objects; what is refused, `tell` hears of with its number."""

    communication, mapping, sent = 0x1400, 0x1600, False

    def __init__(self, slave: Slave, number: int, tell: Callable[[int, Rejected], None]) -> None:
        super().__init__(slave, number)
        self._tell = tell
        self._takes: list[tuple[Entry, Cut]] = []
        self._length = 0
        self._waits_for_sync = False
        self._latched: bytes | None = None
        self._window = 0  # microseconds after a SYNC, 0 for as long as it takes
        self._synced: int | None = None  # when SYNC came
        self._patience = 0  # milliseconds from one to the next, 0 for any time
        self._timer: Timer | None = None
        self._tells = slave.profile.rpdo_emcy

    @property
    def types(self) -> Container[int]:
        """Transmission types the device offers."""
        return self.slave.profile.rpdo_types

    @property
    def objects(self) -> Mapping[Address, Object]:
        """As for every PDO; a written event time counts from the next RPDO."""
        timer = {EVENT_TIMER: Object(write=lambda _: self._stop_watch())}
        return {**super().objects, **self._bound(timer)}

    def listen(self) -> Listening:
        """Its own frames, and SYNC if they wait for it."""
        parts = self.parts()
        self._takes = [(part.entry, _cut(part)) for part in parts if part.entry is not None]
        self._length = length(parts)
        self._waits_for_sync = self.transmission_type in SYNCHRONOUS
        self._window = number(self.slave, WINDOW)
        self._patience = self._setting(EVENT_TIMER) if self.slave.profile.rpdo_emcy else 0
        if self.cob_id is None or not self._waits_for_sync:
            self._latched = None
        if self.cob_id is None:
            self._be_well()
            return
        yield (self.cob_id, False), self.on_data
        if self._waits_for_sync:
            yield from at_sync(self.slave, self.on_sync)

    def on_state(self, state: State) -> None:
        """What waits for a SYNC is forgotten with the PDO communication, and what was wrong."""
        self._latched = self._synced = None
        self._be_well()

    def on_data(self, frame: Frame) -> None:
        """Take the data over, or keep them for SYNC; a frame that is too short is not processed."""
        if self._tells and (len(frame.data) != self._length or self.slave.errors):
            self._judge(len(frame.data))
        if len(frame.data) < self._length:
            reason = f"{len(frame.data)} bytes, {self._length} are mapped"
            self._tell(self.number, Rejected(reason, Abort.TOO_SHORT))
            return
        if self._patience:
            self._watch()
        if not self._waits_for_sync:
            self._take(frame.data)
        elif not self._window or self._within_window():
            self._latched = frame.data

    def on_sync(self, frame: Frame) -> bool:
        """Take the last data over, once."""
        if self._window:
            self._synced = microseconds(self.slave.clock.now)
        data, self._latched = self._latched, None
        if data is not None:
            self._take(data)
        return data is None

    def _take(self, data: bytes) -> None:
        for entry, cut in self._takes:
            try:
                self.slave.write(entry, cut(data))
            except Rejected as refusal:
                frame = Frame(self.cob_id or 0, data)
                self.slave.wire.events.add_refusal(frame, refusal, entry.address)
                self._tell(self.number, refusal)

    def _within_window(self) -> bool:
        """Later than 0x1007 says after a SYNC data are discarded (7.5.2.7)."""
        now = microseconds(self.slave.clock.now)
        return self._synced is None or now - self._synced <= self._window

    # What is told of it: an error lasts until an RPDO comes that has nothing wrong

    def _judge(self, received: int) -> None:
        too_short, too_long = received < self._length, received > self._length > 0
        self._tell_error(TOO_SHORT, lasts=too_short)
        self._tell_error(TOO_LONG, lasts=too_long)
        if not too_short:
            self._tell_error(LATE, lasts=False)

    def _tell_error(self, code: int, *, lasts: bool) -> None:
        why = f"RPDO {self.number} {WHY[code]}"
        if not lasts:
            self.slave.errors.pop(why, None)
        elif self.slave.profile.rpdo_emcy:
            self.slave.errors[why] = code

    def _watch(self) -> None:
        """The next has to come within the event time, counted from this one (7.5.2.35)."""
        self._stop_watch()
        self._timer = self.slave.clock.after(self._patience / 1000, self._on_silence)

    def _stop_watch(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _on_silence(self) -> None:
        self._tell_error(LATE, lasts=True)

    def _be_well(self) -> None:
        self._stop_watch()
        for code in WHY:
            self._tell_error(code, lasts=False)


def _cut(part: Mapped) -> Cut:
    """The same as its `value`, without a look at bits where there are whole bytes."""
    return part.value if part.whole is None else itemgetter(part.whole)
