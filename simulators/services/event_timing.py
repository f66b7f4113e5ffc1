"""When an event-driven TPDO may be sent and when it must: inhibit time and event timer."""

from collections.abc import Callable, Mapping

from simulators.clock import Timer
from simulators.objects import Address, Object, Rejected
from simulators.slave import Slave

INHIBIT_TIME, EVENT_TIMER = 3, 5  # sub-indices


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
            self._event_timer = self._slave.clock.after(time / 1000, self._on_due)

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
