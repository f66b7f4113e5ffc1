"""An expectation at work: from the moment of its step until it is decided."""

from collections.abc import Callable, Sequence
from functools import partial

from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.scenario.expect import Expectation
from canopen_twins.scenario.matchers import Happening, Sign
from canopen_twins.scenario.player.happenings import Position
from canopen_twins.scenario.player.tools import Tools
from canopen_twins.scenario.player.watch import GRAIN, Watch
from canopen_twins.scenario.scenario import Condition, Step
from canopen_twins.scenario.verdict import Finding, Kind

Decide = Callable[["Window", Finding, int], None]


class Window:
    """Tells `decide` once, with the moment of it; begins at a position of what happens."""

    def __init__(self, step: Step, expectation: Expectation, tools: Tools, decide: Decide) -> None:
        self.step = step
        self._expectation = expectation
        self._tools = tools
        self._clock = tools.clock
        self._decide = decide
        self._timer: Timer | None = None
        seconds = expectation.seconds
        self.last = None if seconds is None else self._clock.ticks + microseconds(seconds)
        """The last microsecond, if time ends it."""
        if self.last is not None:
            self._timer = self._clock.at_tick(self.last + GRAIN, self.close)
        self._signs = [self._watch(parts) for parts in _alternatives(expectation)]
        self._watches = [*self._signs]
        if before := expectation.before:
            self._watches.append(self._end_watch(before))

    @property
    def waits(self) -> bool:
        """Whether a condition ends it, which may still come."""
        return self._expectation.before is not None

    def _watch(self, parts: Sequence[Sign]) -> Watch:
        return Watch(parts, self._tools.nodes[self.step.node], self._clock, self._seen)

    def _end_watch(self, before: Condition) -> Watch:
        came = partial(self._came_before, before.what)
        return Watch(
            before.what.parts, self._tools.nodes[before.node], self._clock, came, before.nth
        )

    def open(self, since: Position) -> None:
        """Hear what has happened already at this microsecond, and everything from now on."""
        self._tools.happenings.listen(self._hear)
        for happening in self._tools.happenings.since(since):
            self._hear(happening)

    def close(self) -> None:
        """It has not been seen, by now."""
        if not self.over:
            tick = self._clock.ticks - GRAIN if self.last is None else self.last
            self._conclude(self._missed(), tick)

    def drop(self) -> None:
        """It does not matter any more."""
        self._stop()

    @property
    def over(self) -> bool:
        """Whether it has been decided."""
        return all(watch.over for watch in self._watches)

    def _hear(self, happening: Happening) -> None:
        if self.last is None or self._clock.ticks <= self.last:
            for watch in self._watches:
                if not watch.over:
                    watch.hear(happening)

    def _seen(self, told: str) -> None:
        kind = Kind.FAIL if self._expectation.never else Kind.PASS
        self._conclude(Finding(kind, told), self._now)

    def _came_before(self, sign: Sign, told: str) -> None:
        missed = self._missed()
        seen = missed.seen if missed.kind is Kind.PASS else f"{missed.seen}, before {sign}: {told}"
        self._conclude(Finding(missed.kind, seen), self._now)

    def _missed(self) -> Finding:
        there, told = self._signs[0].now
        return Finding(Kind.PASS if there != self._expectation.never else Kind.FAIL, told)

    @property
    def _now(self) -> int:
        """What a look shows is how it was before the clock went on."""
        looks = self._expectation.sign.looks
        return self._clock.ticks - GRAIN if looks else self._clock.ticks

    def _conclude(self, finding: Finding, tick: int) -> None:
        self._stop()
        self._decide(self, finding, tick)

    def _stop(self) -> None:
        self._tools.happenings.ignore(self._hear)
        if self._timer is not None:
            self._timer.cancel()
        for watch in self._watches:
            watch.stop()


def _alternatives(expectation: Expectation) -> Sequence[Sequence[Sign]]:
    """All parts have to be seen, or none of them may be."""
    parts = expectation.sign.parts
    return [(part,) for part in parts] if expectation.never else [parts]
