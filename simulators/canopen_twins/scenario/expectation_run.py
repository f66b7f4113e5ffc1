"""An expectation from the moment of its step until it is decided, and what watches for it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial

from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.device.node import Node
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.bus_events import BusEvent, BusEvents, Position
from canopen_twins.scenario.matchers import Condition, Matcher
from canopen_twins.scenario.scenario import Step
from canopen_twins.scenario.verdict import Finding, Kind

GRAIN = 1  # microsecond: a moment of the clock is over when the next one begins
TOLD = 5  # things in one line


class Watch:
    """Calls `seen` with words when all parts of a matcher have matched for the n-th time.

    That is once, or `again` and again until it is stopped.

    Somebody hands it the events of the bus, or it listens; looks at a node are its own, once a
    cycle of its device, but for those at which nothing can have changed. What is polled is seen at
    the first look at which it is there, and then again when it has been away.
    """

    def __init__(
        self,
        parts: Sequence[Matcher],
        node: Node,
        bus: BusEvents,
        seen: Callable[[str], None],
        nth: int = 1,
    ) -> None:
        self.active = True
        """Whether it goes on."""
        self.again = False
        """Whether it goes on when it has seen it."""
        self.silence: float | None = None
        """If it is when they have matched, and then not again for so many seconds."""
        self.sources = {source for part in parts if (source := part.source(node)) is not None}
        """Of the events that it wants to hear."""
        self._parts = parts
        self._node = node
        self._bus = bus
        self._seen = seen
        self._nth = self._to_come = nth
        self._missing = list(parts)
        self._told: list[str] = []
        self._similar: deque[str] = deque(maxlen=TOLD)
        self._there = False
        self._looked = -1  # microsecond of the last look
        self._cycle = microseconds(node.device.cycle)
        self._listens = False
        self._timer: Timer | None = None
        if parts[0].polled:
            self._timer = bus.clock.at_tick(bus.clock.ticks + GRAIN, self._look)

    @classmethod
    def of(cls, condition: Condition, bus: BusEvents, seen: Callable[[str], None]) -> Watch:
        """For a condition, wherever it stands."""
        node = bus.nodes[condition.node]
        watch = cls(condition.matcher.parts, node, bus, seen, condition.nth)
        watch.silence = condition.missing
        return watch

    def listen(self, since: Position) -> None:
        """Take the events from a position on; `seen` is called in the middle of what happens."""
        self._listens = True
        self._bus.listen(self.hear, self.sources)
        for event in self._bus.since(since):
            self.hear(event)

    def hear(self, event: BusEvent) -> None:
        """Take an event."""
        for part in self._missing:
            if self.active and part.resembles(event, self._node):
                told = part.describe(event)
                if part.matches(event, self._node):
                    self._take(part, told)
                    return
                self._similar.append(told)

    def stop(self) -> None:
        """It does not matter any more."""
        self.active = False
        if self._timer is not None:
            self._timer.cancel()
        if self._listens:
            self._listens = False
            self._bus.ignore(self.hear, self.sources)

    @property
    def now(self) -> tuple[bool, str]:
        """Whether it is there at a look, and how that looks; or what came instead of it."""
        if self._parts[0].polled:
            return self._parts[0].poll(self._node)
        return False, f"only {', '.join(self._similar)}" if self._similar else "none came"

    def _take(self, part: Matcher, told: str) -> None:
        self._missing = [other for other in self._missing if other is not part]
        self._told.append(told)
        if not self._missing:
            self._matched(", ".join(self._told))

    def _matched(self, told: str) -> None:
        if self.silence is None:
            self._count(told)
            return
        self._missing, self._told = list(self._parts), []
        if self._timer is not None:
            self._timer.cancel()
        clock = self._bus.clock
        end = clock.ticks + microseconds(self.silence)
        self._timer = clock.at_tick(end, partial(self._count, "none came"))

    def _count(self, told: str) -> None:
        self._to_come -= 1
        self._missing, self._told = list(self._parts), []
        if not self._to_come:
            self._to_come = self._nth
            if not self.again:
                self.stop()
            self._seen(told)

    def _look(self) -> None:
        clock, part = self._bus.clock, self._parts[0]
        if part.stands and self._node.changed_at < self._looked:
            self._timer = clock.at_tick(clock.after_idling(self._cycle), self._look)
            return
        self._timer = clock.at_tick(clock.ticks + self._cycle, self._look)
        self._looked = clock.ticks
        there, told = part.poll(self._node)
        before, self._there = self._there, there
        if there and not before:
            self._count(told)


class ExpectationRun:
    """Calls `decided` once with itself, the finding and the microsecond of it, unless dropped."""

    def __init__(
        self,
        step: Step,
        expectation: Expectation,
        bus: BusEvents,
        decided: Callable[[ExpectationRun, Finding, int], None],
    ) -> None:
        self.step = step
        self._expectation = expectation
        self._bus = bus
        self._clock = bus.clock
        self._decided = decided
        self._timer: Timer | None = None
        seconds = expectation.seconds
        self.last = None if seconds is None else self._clock.ticks + microseconds(seconds)
        """The last microsecond, if time ends it."""
        if self.last is not None:
            self._timer = self._clock.at_tick(self.last + GRAIN, self.close)
        node = bus.nodes[step.node]
        self._watches = [Watch(each, node, bus, self._seen) for each in _alternatives(expectation)]
        self._meant = self._watches[0]
        if (before := expectation.before) is not None:
            came = partial(self._came_before, before)
            self._watches.append(Watch.of(before, bus, came))
        self._sources = {source for watch in self._watches for source in watch.sources}

    @property
    def waits(self) -> bool:
        """Whether a condition ends it, which may still come."""
        return self._expectation.before is not None

    def open(self, since: Position) -> None:
        """Hear what has happened already at this microsecond, and everything from now on."""
        self._bus.listen(self._hear, self._sources)
        for event in self._bus.since(since):
            self._hear(event)

    def close(self) -> None:
        """It has not been seen, by now."""
        if self._meant.active:
            tick = self._clock.ticks - GRAIN if self.last is None else self.last
            self._decide(self._missed(), tick)

    def drop(self) -> None:
        """It does not matter any more."""
        self._bus.ignore(self._hear, self._sources)
        if self._timer is not None:
            self._timer.cancel()
        for watch in self._watches:
            watch.stop()

    def _hear(self, event: BusEvent) -> None:
        if self.last is None or self._clock.ticks <= self.last:
            for watch in self._watches:
                if watch.active:
                    watch.hear(event)

    def _seen(self, told: str) -> None:
        kind = Kind.FAIL if self._expectation.never else Kind.PASS
        self._decide(Finding(kind, told), self._now)

    def _came_before(self, before: Condition, told: str) -> None:
        kind, seen = self._missed()
        if kind is not Kind.PASS:
            seen = f"{seen}, before {before}: {told}"
        self._decide(Finding(kind, seen), self._now)

    def _missed(self) -> Finding:
        there, told = self._meant.now
        return Finding(Kind.PASS if there != self._expectation.never else Kind.FAIL, told)

    @property
    def _now(self) -> int:
        """What a look shows is how it was before the clock went on."""
        polled = self._expectation.matcher.polled
        return self._clock.ticks - GRAIN if polled else self._clock.ticks

    def _decide(self, finding: Finding, tick: int) -> None:
        self.drop()
        self._decided(self, finding, tick)


def _alternatives(expectation: Expectation) -> Sequence[Sequence[Matcher]]:
    """All parts have to be seen, or none of them may be."""
    parts = expectation.matcher.parts
    return [(part,) for part in parts] if expectation.never else [parts]
