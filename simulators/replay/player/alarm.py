"""A condition at work: it goes off once."""

from collections.abc import Callable

from simulators.replay.player.crew import Crew
from simulators.replay.player.senses import Position
from simulators.replay.player.watch import Watch
from simulators.replay.scenario import Condition


class Alarm:
    """Calls `go_off` in the middle of what happens, where nobody may act; it is set once."""

    def __init__(self, condition: Condition, crew: Crew, go_off: Callable[[], object]) -> None:
        node, parts = crew.nodes[condition.node], condition.what.parts
        self._watch = Watch(parts, node, crew.clock, self._seen, condition.nth)
        self._senses = crew.senses
        self._go_off = go_off

    def set(self, since: Position) -> None:
        """Watch from here on."""
        self._senses.listen(self._watch.hear)
        for happening in self._senses.since(since):
            if not self._watch.over:
                self._watch.hear(happening)

    def stop(self) -> None:
        """It does not matter any more."""
        if not self._watch.over:
            self._watch.stop()
            self._senses.ignore(self._watch.hear)

    def _seen(self, told: str) -> None:
        self._senses.ignore(self._watch.hear)
        self._go_off()
