"""A value over time: a point for every change, thinned out when there are too many."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from typing import Generic, NamedTuple, TypeVar

from canopen_twins.device.chart import Band

V = TypeVar("V")

MOST = 4000  # points of a track
TELLING = 4  # points at most that a part of it is reduced to
PARTS = MOST // TELLING - 1  # the very first point is kept as well


class Span(NamedTuple):
    """A time, in seconds."""

    start: float
    end: float


class Point(NamedTuple, Generic[V]):
    """From this time on the value was this."""

    time: float
    """Seconds."""
    value: V


Points = Sequence[Point[V]]
Thin = Callable[[Points[V]], Points[V]]
"""Takes the points of a short time, returns the few that must be seen."""


class Track(Generic[V]):
    """Holds until the next point."""

    def __init__(self, thin: Thin[V]) -> None:
        self._thin = thin
        self._points: list[Point[V]] = []

    def add(self, time: float, value: V) -> None:
        """It is so now."""
        if self._points and self._points[-1].value == value:
            return
        self._points.append(Point(time, value))
        if len(self._points) > 2 * MOST:
            self._points = self._thinned()

    @property
    def points(self) -> Points[V]:
        """At most `MOST` of them."""
        return self._points if len(self._points) <= MOST else self._thinned()

    def spans(self, end: float) -> Iterator[tuple[Span, V]]:
        """What held from when to when, up to the end in seconds."""
        points = self.points
        ends = [*(point.time for point in points[1:]), end]
        for point, until in zip(points, ends, strict=True):
            yield Span(point.time, until), point.value

    def _thinned(self) -> list[Point[V]]:
        first, last = self._points[0], self._points[-1]
        width = (last.time - first.time) / PARTS

        def part(point: Point[V]) -> int:
            return min(int((point.time - first.time) / width), PARTS - 1)

        parts = (list(points) for _, points in groupby(self._points, part))
        kept = [first, *(point for points in parts for point in self._thin(points))]
        return kept[1:] if kept[1] == first else kept


def extremes(points: Points[float | None]) -> Points[float | None]:
    """The lowest, the highest, a gap, and the last: a short spike survives."""
    numbers = [(point.value, at) for at, point in enumerate(points) if point.value is not None]
    gap = [at for at, point in enumerate(points) if point.value is None]
    kept = {len(points) - 1, *gap[:1]}
    if numbers:
        kept |= {min(numbers)[1], max(numbers)[1]}
    return [points[at] for at in sorted(kept)]


def worst(points: Points[Band]) -> Points[Band]:
    """The worst, and the last."""
    at = max(range(len(points)), key=lambda at: points[at].value.mood)
    return [points[at], points[-1]] if at < len(points) - 1 else [points[-1]]


def joined(spans: Iterable[Span]) -> Sequence[Span]:
    """The times that are in any of these, which come in their order."""
    found: list[Span] = []
    for span in spans:
        if found and span.start <= found[-1].end:
            found[-1] = Span(found[-1].start, max(found[-1].end, span.end))
        else:
            found.append(span)
    return found
