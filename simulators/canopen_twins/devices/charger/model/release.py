"""Software and hardware release: who may switch the high voltage on, and who has done so."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, IntFlag, auto

from canopen_twins.devices.charger.model.ticks import NEVER, TICK_MS


class ReleaseSource(IntFlag):
    """Where a software release comes from, as in the bits of 2002h:02h."""

    AUTOSTART = 1 << 0
    ANALOG = 1 << 1
    HMI = 1 << 2
    CANOPEN = 1 << 3
    ETHERNET = 1 << 4


EVERY = ~ReleaseSource(0)
BUS = ReleaseSource.CANOPEN | ReleaseSource.ETHERNET
ANALOG_ON, ANALOG_OFF = 2.0, 1.0  # % (A-63)


class ReleaseState(Enum):
    """LOCKED: no software release. ARMED: it is there. ON: so is the hardware release."""

    LOCKED = auto()
    ARMED = auto()
    ON = auto()
    FAULT = auto()


class ReleaseEvent(Enum):
    """What moves the release."""

    SET = auto()
    RESET = auto()
    CLOSED = auto()
    OPENED = auto()
    TRIPPED = auto()
    CLEARED = auto()


# An event that a state does not name changes nothing.
NEXT: Mapping[ReleaseState, Mapping[ReleaseEvent, ReleaseState]] = {
    ReleaseState.LOCKED: {
        ReleaseEvent.SET: ReleaseState.ARMED,
        ReleaseEvent.TRIPPED: ReleaseState.FAULT,
    },
    ReleaseState.ARMED: {
        ReleaseEvent.RESET: ReleaseState.LOCKED,
        ReleaseEvent.CLOSED: ReleaseState.ON,
        ReleaseEvent.TRIPPED: ReleaseState.FAULT,
    },
    ReleaseState.ON: {
        ReleaseEvent.RESET: ReleaseState.LOCKED,
        ReleaseEvent.OPENED: ReleaseState.ARMED,
        ReleaseEvent.TRIPPED: ReleaseState.FAULT,
    },
    ReleaseState.FAULT: {ReleaseEvent.CLEARED: ReleaseState.LOCKED},
}


@dataclass
class Release:
    """One software release, whoever gave it: the last event wins (A-40)."""

    timed: ReleaseSource = EVERY  # whose releases the timeout ends
    closed: bool = True  # the hardware release
    state: ReleaseState = field(default=ReleaseState.LOCKED, init=False)
    source: ReleaseSource = field(default=ReleaseSource(0), init=False)
    _given: int = field(default=0, init=False)  # tick
    _analog: bool = field(default=False, init=False)

    @property
    def software(self) -> bool:
        """Whether the software release is set."""
        return self.state in (ReleaseState.ARMED, ReleaseState.ON)

    def set(self, source: ReleaseSource, now: int) -> None:
        """Give the software release; without effect in FAULT."""
        self._handle(ReleaseEvent.SET)
        self.source, self._given = source, now

    def reset(self) -> None:
        """Take the software release away."""
        self._handle(ReleaseEvent.RESET)

    def restrict(self, enabled: ReleaseSource) -> None:
        """A release from a source that is not enabled any more is taken away (A-41)."""
        if self.source not in enabled:
            self.reset()

    def contact(self, closed: bool) -> None:
        """The hardware release; without it the software release stays (A-47)."""
        self.closed = closed
        self._handle(ReleaseEvent.CLOSED if closed else ReleaseEvent.OPENED)

    def block(self, tripped: bool) -> None:
        """An error blocks everything until none is left that does (A-48)."""
        self._handle(ReleaseEvent.TRIPPED if tripped else ReleaseEvent.CLEARED)

    def restart(self) -> None:
        """As after switching on: neither released nor in FAULT."""
        self.state, self._analog = ReleaseState.LOCKED, False

    def rewind(self, now: int) -> None:
        """Let the timeout start afresh (A-42)."""
        self._given = now

    def follow(self, level: float | None, now: int) -> None:
        """An analog setpoint (%) that rises or falls acts like a key; None has no say."""
        if level is None:
            self._analog = False
        elif not self._analog and level > ANALOG_ON:
            self._analog = True
            self.set(ReleaseSource.ANALOG, now)
        elif self._analog and level < ANALOG_OFF:
            self._analog = False
            self.reset()

    def expire(self, now: int, timeout: int) -> None:
        """Take the release away when `timeout` (ms, 0 = none) has passed (2002h:04h)."""
        if self.quiet(now, timeout) <= 0:
            self.reset()

    def quiet(self, now: int, timeout: int) -> int:
        """Ticks until it expires."""
        if not (timeout and self.software and self.source in self.timed):
            return NEVER
        return self._given + -(-timeout // TICK_MS) - now

    def _handle(self, event: ReleaseEvent) -> None:
        self.state = NEXT[self.state].get(event, self.state)
        if self.closed:  # a release that finds the contact closed goes on at once
            self.state = NEXT[self.state].get(ReleaseEvent.CLOSED, self.state)
