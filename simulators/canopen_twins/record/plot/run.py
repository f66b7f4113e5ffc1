"""A run as it is seen: its nodes after each moment at which something happened, and its verdict."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, NamedTuple

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.chart import Band, Curve, Mood
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.record.plot.track import Span, Track, extremes, worst
from canopen_twins.scenario import Kind, Outcome, Player, PlayerEvent, Verdict
from canopen_twins.slave.emcy import EMCY_LENGTH, emcy_id, emcy_of
from canopen_twins.slave.service import State

GRAIN = 1  # microsecond: a moment of the clock is over when the next one begins
MOST_MARKS = 500
MOST_FRAMES = 2000
POWER_OFF = Band("power off", Mood.OFF)
NMT: Mapping[State, Band] = {
    State.INITIALISING: Band("initialising", Mood.OFF),
    State.PRE_OPERATIONAL: Band("pre-operational", Mood.WAITING),
    State.OPERATIONAL: Band("operational", Mood.ACTIVE),
    State.STOPPED: Band("stopped", Mood.WARNING),
}


class SentEmcy(NamedTuple):
    """An EMCY that went out."""

    time: float
    """Seconds."""
    code: int
    words: str


class SentFrame(NamedTuple):
    """A frame, and what it meant when it was sent."""

    time: float
    """Seconds."""
    sender: str
    frame: Frame
    words: str


class CurveHistory:
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


class NodeHistory:
    """Is told when to look, and hears the frames of its node; acts on nothing."""

    def __init__(self, node: Node) -> None:
        self.name = node.wire.name
        self.title = f"{self.name}, node {node.node_id}"
        self._node = node
        self._decoder = Decoder([node])
        chart = node.device.chart
        self.curves = [CurveHistory(curve) for curve in chart.curves]
        self.nmt: Track[Band] = Track(worst)
        self.state: Track[Band] | None = Track(worst) if chart.band else None
        self.faults: dict[str, Track[bool]] = {}
        self.blows: list[tuple[str, float]] = []
        """Faults that were over at once, and when."""
        self.emergencies: list[SentEmcy] = []
        self.untold = 0
        """Emergencies beyond `MOST_MARKS`."""

    def look(self, time: float) -> None:
        """Take down how it is at this time, in seconds."""
        powered = self._node.powered
        chart = self._node.device.chart  # anew: a power-on may have made another model
        for history, curve in zip(self.curves, chart.curves, strict=True):
            history.look(time, curve, powered)
        self.nmt.add(time, NMT[self._node.state] if powered else POWER_OFF)
        if self.state is not None and chart.band is not None:
            self.state.add(time, chart.band() if powered else POWER_OFF)
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
        if sender != self.name or slave is None or len(frame.data) != EMCY_LENGTH:
            return
        if frame.can_id != emcy_id(slave):
            return
        if len(self.emergencies) == MOST_MARKS:
            self.untold += 1
            return
        code = emcy_of(frame.data).code
        self.emergencies.append(SentEmcy(time, code, self._decoder.words(frame)))


def _short(words: str) -> str:
    return words.removesuffix("()")


class Run:
    """Looks at the nodes of a segment from before anything has happened; leaves no trace.

    Between two moments of the clock nothing changes but by a frame from outside, so nothing escapes
    it, and a device at rest costs nothing.
    """

    def __init__(self, segment: Segment[Node], player: Player | None) -> None:
        self.nodes = [NodeHistory(node) for node in segment.nodes]
        self.frames: list[SentFrame] = []
        """The first of them."""
        self.unheard = 0
        """Frames beyond `MOST_FRAMES`."""
        self._decoder = Decoder(segment.nodes)
        self._clock = segment.clock
        self._begin = self._clock.ticks
        segment.listeners.append(self._hear)
        self._player = player
        if player is not None:
            player.listeners.append(self._follow)
        self._plan(self._begin + GRAIN)

    @property
    def duration(self) -> float:
        """Seconds since the beginning."""
        return max(self._clock.ticks - self._begin, GRAIN) / MICROSECONDS

    @property
    def heading(self) -> str:
        """What is played, or else who takes part."""
        name = "" if self._player is None else self._player.scenario.name
        return name or "; ".join(node.title for node in self.nodes)

    @property
    def verdict(self) -> Verdict | None:
        """As it is by now; None if there is no scenario."""
        return None if self._player is None else self._player.verdict

    @property
    def outcomes(self) -> Sequence[Outcome]:
        """Of the verdict."""
        return () if self._player is None else self._player.verdict.outcomes

    @property
    def failed(self) -> Sequence[Outcome]:
        """What did not come, or could not be carried out; the first of them if they are a crowd."""
        bad = (each for each in self.outcomes if each.kind in (Kind.FAIL, Kind.ERROR))
        return sorted(bad, key=lambda each: each.time)[:MOST_MARKS]

    def faults(self, node: NodeHistory) -> Sequence[tuple[str, Span]]:
        """The faults of a node with their times, in the order in which they came."""
        found = [
            (name, span)
            for name, track in node.faults.items()
            for span, active in track.spans(self.duration)
            if active
        ]
        found += [(name, Span(time, time)) for name, time in node.blows]
        return sorted(found, key=lambda each: each[1])

    def _look(self) -> None:
        time = (self._clock.ticks - GRAIN - self._begin) / MICROSECONDS
        for node in self.nodes:
            node.look(time)
        upcoming = self._clock.next_tick
        if isfinite(upcoming):
            self._plan(int(upcoming) + GRAIN)

    def _plan(self, tick: int) -> None:
        self._due, self._timer = tick, self._clock.at_tick(tick, self._look)

    def _follow(self, event: PlayerEvent) -> None:
        for node in self.nodes:
            if event.kind == "inject" and event.node == node.name:
                node.hit(event.time, event.fields)

    def _hear(self, frame: Frame, sender: str) -> None:
        if not self._timer.pending or self._due > self._clock.ticks + GRAIN:  # from outside
            self._timer.cancel()
            self._plan(self._clock.ticks + GRAIN)
        for node in self.nodes:
            node.hear(self.duration, frame, sender)
        if len(self.frames) == MOST_FRAMES:
            self.unheard += 1
            return
        time = (self._clock.ticks - self._begin) / MICROSECONDS
        self.frames.append(SentFrame(time, sender, frame, self._decoder.words(frame)))
