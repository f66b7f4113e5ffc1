"""The messages that are active: latched when a cause appears, gone only when they are cleared."""

from dataclasses import dataclass, field
from typing import NamedTuple

from simulators.devices.charger.model.catalogue import Catalogue, Kind, Message
from simulators.devices.charger.model.causes import CAUSES, Situation, Test
from simulators.devices.charger.model.ticks import NEVER, Hold, whole_ticks

GONE = {(cause.kind, cause.key): cause.gone for cause in CAUSES}


class Watch(NamedTuple):
    """A cause that is looked for, and the message for it."""

    test: Test
    hold: Hold
    message: Message


@dataclass
class Messages:
    """In the order in which they came."""

    catalogue: Catalogue
    active: list[Message] = field(default_factory=list, init=False)
    _forced: list[Message] = field(default_factory=list, init=False)
    _watches: list[Watch] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.restart()

    @property
    def unreported(self) -> list[tuple[Kind, str]]:
        """What the model notices but the catalogue has no message for."""
        keys = ((cause.kind, cause.key) for cause in CAUSES)
        return [key for key in keys if self.catalogue.keyed(*key) is None]

    @property
    def tripped(self) -> bool:
        """Whether an error is active that switches off."""
        return any(message.trips for message in self.active)

    def has(self, kind: Kind) -> bool:
        """Whether an error, or a warning, is active."""
        return any(message.kind is kind for message in self.active)

    def find(self, kind: Kind, number: int) -> Message | None:
        """The active message with this number."""
        wanted = (kind, number)
        return next((m for m in self.active if (m.kind, m.number) == wanted), None)

    def force(self, message: Message) -> None:
        """A cause outside the model: the message appears, and cannot be cleared for now."""
        if message not in self._forced:
            self._forced.append(message)
        self._latch(message)

    def unforce(self, message: Message) -> None:
        """The cause outside the model is gone; the message stays until it is cleared."""
        if message in self._forced:
            self._forced.remove(message)

    def clear(self, message: Message, situation: Situation) -> None:
        """Take a message away after the internal check: its cause must be gone (A-35)."""
        gone = GONE.get((message.kind, message.key))
        if message not in self._forced and (gone is None or gone(situation)):
            self.active.remove(message)

    def restart(self) -> None:
        """Nothing is active; what still has its cause comes back."""
        self._watches = [
            Watch(cause.test, Hold(whole_ticks(cause.delay)), message)
            for cause in CAUSES
            if (message := self.catalogue.keyed(cause.kind, cause.key))
        ]
        self.active.clear()
        for message in self._forced:
            self._latch(message)

    def judge(self, now: int, situation: Situation) -> None:
        """Latch what has appeared."""
        for test, hold, message in self._watches:
            hold.update(now, test(situation))
            if hold.due(now):
                self._latch(message)

    def quiet(self, now: int) -> int:
        """Ticks until something may appear by itself."""
        return min((watch.hold.quiet(now) for watch in self._watches), default=NEVER)

    def _latch(self, message: Message) -> None:
        if message not in self.active:
            self.active.append(message)
