"""A run as it is drawn, and the same in words."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from simulators.plot.track import Points, V
from simulators.plot.view import MOST_MARKS, View
from simulators.replay.verdict import Kind, Outcome, Verdict


class Span(NamedTuple):
    """A time, in seconds."""

    start: float
    end: float


def joined(spans: Iterable[Span]) -> Sequence[Span]:
    """The times that are in any of these, which come in their order."""
    found: list[Span] = []
    for span in spans:
        if found and span.start <= found[-1].end:
            found[-1] = Span(found[-1].start, max(found[-1].end, span.end))
        else:
            found.append(span)
    return found


@dataclass(frozen=True)
class Run:
    """What was seen, and what it was judged to be."""

    name: str
    verdict: Verdict | None
    """None: there was no scenario."""
    views: Sequence[View]
    duration: float
    """Seconds."""

    @property
    def heading(self) -> str:
        """What was played, or else who took part."""
        return self.name or "; ".join(view.title for view in self.views)

    @property
    def outcomes(self) -> Sequence[Outcome]:
        """Of the verdict."""
        return () if self.verdict is None else self.verdict.outcomes

    @property
    def passed(self) -> Sequence[Outcome]:
        """What came as expected."""
        return [each for each in self.outcomes if each.kind is Kind.PASS]

    @property
    def skipped(self) -> Sequence[Outcome]:
        """What was left out."""
        return [each for each in self.outcomes if each.kind is Kind.SKIP]

    @property
    def failed(self) -> Sequence[Outcome]:
        """What did not, or could not be carried out; the first of them if they are a crowd."""
        bad = (each for each in self.outcomes if each.kind in (Kind.FAIL, Kind.ERROR))
        return sorted(bad, key=lambda each: each.time)[:MOST_MARKS]

    def lasting(self, points: Points[V]) -> Iterator[tuple[Span, V]]:
        """What held from when to when."""
        ends = [*(point.time for point in points[1:]), self.duration]
        for point, end in zip(points, ends, strict=True):
            yield Span(point.time, end), point.value

    def faults(self, view: View) -> Sequence[tuple[str, Span]]:
        """The faults of a node with their times, in the order in which they came."""
        found = [
            (name, span)
            for name, track in view.faults.items()
            for span, active in self.lasting(track.points)
            if active
        ]
        found += [(name, Span(time, time)) for name, time in view.blows]
        return sorted(found, key=lambda each: each[1])
