"""The folder of a record: filled while a run goes on, and read to live through the run again."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TextIO

from canopen_twins import devices
from canopen_twins.bench.twin import ORDERS, carry_out
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.files.whole import folder_part
from canopen_twins.record.journal import END, HEARD, ORDER, STALL, EventLine, Journal, read_events
from canopen_twins.record.manifest import DEVICES, Manifest, digest, read_manifest, version_now
from canopen_twins.record.trace import Observer
from canopen_twins.record.trace_reader import read_frames
from canopen_twins.scenario import Player, Scenario, begin, load, play, print_frames
from canopen_twins.scenario.scenario import NodeSpec
from canopen_twins.scenario.started import START, STOP, read_text, start_now, stop_now

GRAIN = 1 / MICROSECONDS
NO_FILES: Mapping[str, bytes] = MappingProxyType({})
RUN, SCENARIO, TRACE, EVENTS = "run.json", "scenario.yaml", "trace.log", "events.jsonl"


@contextmanager
def record(
    folder: Path, manifest: Manifest, scenario: bytes | None, files: Mapping[str, bytes] = NO_FILES
) -> Iterator[Observer]:
    """Fills a new folder; a run that is cut short leaves it under a name that ends in `.part`.

    Args:
        folder: There must be none yet.
        manifest: What there is to say before the run begins.
        scenario: The file that is played, if there is one.
        files: What describes devices, by its paths in the record.

    Raises:
        UserError: there is something already, or it cannot be written.
    """
    with folder_part(folder) as part:
        (part / RUN).write_text(manifest.text, "utf-8", newline="\n")
        if scenario is not None:
            (part / SCENARIO).write_bytes(scenario)
        for name, content in files.items():
            (part / name).parent.mkdir(parents=True, exist_ok=True)
            (part / name).write_bytes(content)
        with _lines(part / TRACE) as trace, _lines(part / EVENTS) as events:
            journals: list[Journal] = []

            def attach(segment: Segment[Node], player: Player | None) -> None:
                print_frames(trace)(segment, player)
                journals.append(Journal(events, segment, player))

            try:
                yield attach
                for journal in journals:
                    journal.end()
            finally:  # that the supply goes is no part of the run
                for journal in journals:
                    journal.close()


def _lines(path: Path) -> TextIO:
    """Each line is on its way to the disk when it is complete."""
    return path.open("w", buffering=1, encoding="utf-8", newline="\n")


class Recorded:
    """A record as it is read: everything is looked at before anything is played.

    Raises:
        UserError: something of it is missing, or run.json is damaged.
    """

    def __init__(self, folder: Path) -> None:
        if not folder.is_dir():
            raise UserError(f"{folder} is no record: a record is a directory")
        self.folder = folder
        self.manifest: Manifest = read_manifest(folder / RUN)
        self.trace, self._events = folder / TRACE, folder / EVENTS
        played = [self.scenario] if self.manifest.scenario else []
        for path in (self.trace, self._events, *played):
            if not path.is_file():
                raise UserError(f"{path} is missing")

    @property
    def scenario(self) -> Path:
        """The file that was played, as it was then."""
        return self.folder / SCENARIO

    @property
    def device_files(self) -> dict[str, bytes]:
        """What describes its devices, by its paths in the record."""
        files = sorted(path for path in (self.folder / DEVICES).rglob("*") if path.is_file())
        return {path.relative_to(self.folder).as_posix(): path.read_bytes() for path in files}

    @property
    def events(self) -> Iterator[EventLine]:
        """What happened beside the frames; raises `UserError` where that is damaged."""
        return read_events(self._events)

    @property
    def end(self) -> float:
        """When the run was over, in seconds; of one that was cut short the last that is told."""
        time = 0.0
        for event in self.events:
            time = event.time
            if event.kind == END:
                return time
        return max([time, *(sent.tick / MICROSECONDS for sent in read_frames(self.trace))])

    @property
    def other_versions(self) -> str:
        """What it was made with and is not the same now, in words; empty if everything is."""
        return ", ".join(
            f"{name} {then} (now {now})"
            for name, then in self.manifest.versions.items()
            if then != (now := version_now(name))
        )

    def load_scenario(self) -> Scenario | None:
        """The scenario, called as it was when it was recorded.

        Raises:
            UserError: it cannot be played any more, or a file that its settings name is another.
        """
        for name, then in self.manifest.files.items():
            if not Path(name).is_file() or digest(Path(name)) != then:
                raise UserError(f"{name} is not what it was when {self.folder} was recorded")
        if self.manifest.scenario is None:
            return None
        nodes = {  # with every setting they had, so that no default of today matters
            node.name: NodeSpec(devices.find(node.device, self.folder), node.settings)
            for node in self.manifest.nodes
        }
        kinds = iter([spec.device for spec in nodes.values()])

        def find(name: str) -> type[Device]:
            """The scenario is asked node by node; where its files lay then does not matter."""
            if (kind := next(kinds, None)) is None:
                raise UserError(f"{self.scenario} has more nodes than {RUN}")
            return kind

        scenario = load(self.scenario, find)
        return replace(scenario, file=Path(self.manifest.scenario), nodes=nodes)


def reproduce(recorded: Recorded, observers: Iterable[Observer]) -> None:
    """The same devices and scenario, and what the record has heard from outside at its times.

    Raises:
        UserError: the record is damaged, or there is no such device any more.
    """
    scenario = recorded.load_scenario()
    if scenario is not None and recorded.manifest.kind == "play":
        play(scenario, observers=observers)
        return
    segment: Segment[Node] = Segment()
    nodes = {
        node.name: connect(segment, node.create(recorded.folder), node.name)
        for node in recorded.manifest.nodes
    }
    player = Player(scenario, segment, nodes) if scenario else None
    begin(segment, player, observers)
    segment.deliver()
    hands = Hands(segment, player)
    for event in recorded.events:
        if event.kind == HEARD:
            segment.advance_to(event.time)
            segment.send(Frame.parse(str(event.fields.get("frame"))))
        elif event.kind == ORDER:
            segment.advance_to(event.time)
            hands.repeat(event)
        elif event.kind == STALL:
            segment.advance_to(event.time - GRAIN)  # it counts from this microsecond on
            segment.clock.unseen = _unseen(event)
    segment.advance_to(recorded.end)


def _unseen(event: EventLine) -> float:
    unseen = event.fields.get("unseen")
    if isinstance(unseen, bool) or not isinstance(unseen, int | float):
        raise UserError(f"the record is damaged: {event}")
    return unseen


class Hands:
    """What was done by the control port, done again; what was refused is refused again."""

    def __init__(self, segment: Segment[Node], player: Player | None) -> None:
        self._segment = segment
        self._nodes = {node.wire.name: node for node in segment.nodes}
        self._player = player

    def repeat(self, event: EventLine) -> None:
        """Do what an event tells of, now; raises `UserError` if nobody could have done it."""
        word, arguments = str(event.fields.get("order")), event.fields.get("arguments")
        if not isinstance(arguments, list):
            raise UserError(f"the record is damaged: {event}")
        if word == START and len(arguments) == 2:
            name, text = map(str, arguments)
            scenario = read_text(name, text, self._segment.nodes)
            self._player = start_now(self._segment, scenario, text)
        elif word == STOP and self._player is not None:
            stop_now(self._segment, self._player)
        elif word in ORDERS and event.node in self._nodes:
            with suppress(UserError):
                carry_out(self._segment, self._nodes[event.node], word, *arguments)
        else:
            raise UserError(f"the record is damaged: {event}")
