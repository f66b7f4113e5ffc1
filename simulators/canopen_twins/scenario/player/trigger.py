"""A condition at work: it goes off once."""

from collections.abc import Callable

from canopen_twins.scenario.player.happenings import Position
from canopen_twins.scenario.player.tools import Tools
from canopen_twins.scenario.player.watch import Watch
from canopen_twins.scenario.scenario import Condition


class Trigger:
    """Calls `go_off` in the middle of what happens, where nobody may act; it is set once."""

    def __init__(self, condition: Condition, tools: Tools, go_off: Callable[[], object]) -> None:
        node, parts = tools.nodes[condition.node], condition.what.parts
        self._watch = Watch(parts, node, tools.clock, self._seen, condition.nth)
        self._happenings = tools.happenings
        self._go_off = go_off

    def set(self, since: Position) -> None:
        """Watch from here on."""
        self._happenings.listen(self._watch.hear)
        for happening in self._happenings.since(since):
            if not self._watch.over:
                self._watch.hear(happening)

    def stop(self) -> None:
        """It does not matter any more."""
        if not self._watch.over:
            self._watch.stop()
            self._happenings.ignore(self._watch.hear)

    def _seen(self, told: str) -> None:
        self._happenings.ignore(self._watch.hear)
        self._go_off()
