"""What there was to see of one node."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from simulators.chart import Band, Curve, Mood
from simulators.decode import Decoder
from simulators.frame import Frame
from simulators.node import Node
from simulators.plot.track import Track, extremes, worst
from simulators.services import State
from simulators.services.emcy import EMCY_LENGTH, emcy_id, emcy_of

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

    def look(self, time: float, powered: bool) -> None:
        """Without power there is nothing to be seen."""
        curve = self.curve
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
        self._state = chart.band
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
        for strip in self.strips:
            strip.look(time, powered)
        self.nmt.add(time, NMT[self._node.state] if powered else POWER_OFF)
        if self.state is not None and self._state is not None:
            self.state.add(time, self._state() if powered else POWER_OFF)
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
