"""A record as it is read: everything is looked at before anything is played."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from canopen_twins import devices
from canopen_twins import scenario as replay
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.record.about import About, digest, read_about, version_now
from canopen_twins.record.events import END, HEARD, EventLine, read_events
from canopen_twins.record.recorder import EVENTS, RUN, SCENARIO, TRACE
from canopen_twins.record.trace import Observer, read_frames
from canopen_twins.scenario import Player, begin, play
from canopen_twins.scenario.scenario import NodeSpec


class Recorded:
    """The folder of a record.

    Raises:
        UserError: something of it is missing, or run.json is damaged.
    """

    def __init__(self, folder: Path) -> None:
        if not folder.is_dir():
            raise UserError(f"{folder} is no record: a record is a directory")
        self.folder = folder
        self.about: About = read_about(folder / RUN)
        self.trace, self._events = folder / TRACE, folder / EVENTS
        for path in (self.trace, self._events, *([self.scenario] if self.about.scenario else [])):
            if not path.is_file():
                raise UserError(f"{path} is missing")

    @property
    def scenario(self) -> Path:
        """The file that was played, as it was then."""
        return self.folder / SCENARIO

    @property
    def events(self) -> Iterator[EventLine]:
        """What happened beside the frames; raises `UserError` where that is damaged."""
        return read_events(self._events)

    @property
    def heard(self) -> Iterator[tuple[float, Frame]]:
        """The frames that came from outside, each with its time; raises as `events` does."""
        for event in self.events:
            if event.kind == HEARD:
                yield event.time, Frame.parse(str(event.fields.get("frame")))

    @property
    def end(self) -> float:
        """When the run was over, in seconds; of one that was cut short the last that is told."""
        time = 0.0
        for event in self.events:
            time = event.time
            if event.kind == END:
                return time
        for sent in read_frames(self.trace):
            time = max(time, sent.tick / MICROSECONDS)
        return time

    @property
    def other_versions(self) -> str:
        """What it was made with and is not the same now, in words; empty if everything is."""
        now = {name: version_now(name) for name in self.about.versions}
        return ", ".join(
            f"{name} {then} (now {now[name]})"
            for name, then in self.about.versions.items()
            if then != now[name]
        )

    def load_scenario(self) -> replay.Scenario | None:
        """The scenario, called as it was when it was recorded.

        Raises:
            UserError: it cannot be played any more, or a file that its settings name is another.
        """
        for name, then in self.about.files.items():
            if not Path(name).is_file() or digest(Path(name)) != then:
                raise UserError(f"{name} is not what it was when {self.folder} was recorded")
        if self.about.scenario is None:
            return None
        scenario = replay.load(self.scenario)
        return replace(scenario, file=Path(self.about.scenario), nodes=self._nodes)

    @property
    def _nodes(self) -> Mapping[str, NodeSpec]:
        """With every setting they had, so that no default of today matters."""
        return {
            part.name: NodeSpec(devices.find(part.device), part.settings)
            for part in self.about.nodes
        }


def reproduce(recorded: Recorded, observers: Iterable[Observer]) -> None:
    """The same devices and scenario, and what the record has heard from outside at its times.

    Raises:
        UserError: the record is damaged, or there is no such device any more.
    """
    scenario = recorded.load_scenario()
    if scenario is not None and recorded.about.kind == "play":
        play(scenario, observers=observers)
        return
    segment: Segment[Node] = Segment()
    heard = recorded.heard
    nodes = {part.name: connect(segment, part.create(), part.name) for part in recorded.about.nodes}
    player = Player(scenario, segment, nodes) if scenario else None
    begin(segment, player, observers)
    segment.deliver()
    for time, frame in heard:
        segment.advance_to(time)
        segment.send(frame)
    segment.advance_to(recorded.end)
