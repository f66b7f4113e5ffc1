"""What a value was over time: a point for every change, thinned out when there are too many."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Generic, NamedTuple, TypeVar

from canopen_twins.bus.frame import Frame
from canopen_twins.device.chart import Band, Curve, Mood
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.scenario.verdict import Kind, Outcome, Verdict
from canopen_twins.slave.emcy import EMCY_LENGTH, emcy_id, emcy_of
from canopen_twins.slave.service import State

V = TypeVar("V")

MOST = 4000  # points of a track
TELLING = 4  # points at most that a part of it is reduced to
PARTS = MOST // TELLING - 1  # the very first point is kept as well


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


POWER_OFF = Band("power off", Mood.OFF)
NMT: Mapping[State, Band] = {
    State.INITIALISING: Band("initialising", Mood.OFF),
    State.PRE_OPERATIONAL: Band("pre-operational", Mood.WAITING),
    State.OPERATIONAL: Band("operational", Mood.ACTIVE),
    State.STOPPED: Band("stopped", Mood.WARNING),
}
MOST_MARKS = 500


class Emergency(NamedTuple):
    """An EMCY that went out."""

    time: float
    """Seconds."""
    code: int
    words: str


class Strip:
    """One curve of a device, as it ran."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve
        self.actual: Track[float | None] = Track(extremes)
        self.wanted: Track[float | None] | None = Track(extremes) if curve.wanted else None

    def look(self, time: float, curve: Curve, powered: bool) -> None:
        """As the curve is now; without power there is nothing to be seen."""
        self.actual.add(time, curve.actual() if powered else None)
        if self.wanted is not None and curve.wanted is not None:
            self.wanted.add(time, curve.wanted() if powered else None)


class View:
    """Is told when to look, and hears the frames of its node; acts on nothing."""

    def __init__(self, node: Node) -> None:
        self.name = node.wire.name
        self.title = f"{self.name}, node {node.node_id}"
        self._node = node
        self._decoder = Decoder([node])
        chart = node.device.chart
        self.strips = [Strip(curve) for curve in chart.curves]
        self.nmt: Track[Band] = Track(worst)
        self.state: Track[Band] | None = Track(worst) if chart.band else None
        self.faults: dict[str, Track[bool]] = {}
        self.blows: list[tuple[str, float]] = []
        """Faults that were over at once, and when."""
        self.emergencies: list[Emergency] = []
        self.untold = 0
        """Emergencies beyond `MOST_MARKS`."""

    def look(self, time: float) -> None:
        """Take down how it is at this time, in seconds."""
        powered = self._node.powered
        chart = self._node.device.chart  # anew: a power-on may have made another model
        for strip, curve in zip(self.strips, chart.curves, strict=True):
            strip.look(time, curve, powered)
        self.nmt.add(time, NMT[self._node.state] if powered else POWER_OFF)
        if self.state is not None and chart.band is not None:
            self.state.add(time, chart.band() if powered else POWER_OFF)
        self._look_at_faults(time)

    def _look_at_faults(self, time: float) -> None:
        faults = self._node.faults
        active = {_short(faults.words(*fault)) for fault in faults.active.items()}
        for name in sorted(active - self.faults.keys()):
            self.faults[name] = Track(lambda points: points[-2:])
        for name, track in self.faults.items():
            track.add(time, name in active)

    def hit(self, time: float, told: Mapping[str, Any]) -> None:
        """A `fault` with its `parameters` came at this time; what lasts is seen by looking."""
        faults, fault = self._node.faults, told["fault"]
        if faults.known[fault].clear is None and len(self.blows) < MOST_MARKS:
            self.blows.append((_short(faults.words(fault, told["parameters"])), time))

    def hear(self, time: float, frame: Frame, sender: str) -> None:
        """Take an emergency down."""
        slave = self._node.slave
        told = (
            slave is not None and len(frame.data) == EMCY_LENGTH and frame.can_id == emcy_id(slave)
        )
        if sender != self.name or not told:
            return
        if len(self.emergencies) == MOST_MARKS:
            self.untold += 1
            return
        code = emcy_of(frame.data).code
        self.emergencies.append(Emergency(time, code, self._decoder.words(frame)))


def _short(words: str) -> str:
    return words.removesuffix("()")


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
