"""Records a run while it goes on: a folder with all that it takes to live through it again."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from simulators.decode import Decoder
from simulators.node import Node
from simulators.record.about import About
from simulators.record.events import END, HEARD, Happening, write_event
from simulators.record.part import folder_part
from simulators.record.trace import Observer, print_frames
from simulators.replay import Player
from simulators.replay.patterns import EmcyLike
from simulators.segment import Segment
from simulators.services import State
from simulators.wire import Frame

RUN, SCENARIO, TRACE, EVENTS = "run.json", "scenario.yaml", "trace.log", "events.jsonl"
EMCY = EmcyLike()


@contextmanager
def record(folder: Path, told: About, scenario: bytes | None) -> Iterator[Observer]:
    """Fills a new folder; a run that is cut short leaves it under a name that ends in `.part`.

    Raises:
        UserError: there is something already, or it cannot be written.
    """
    with folder_part(folder) as part:
        (part / RUN).write_text(told.text, "utf-8", newline="\n")
        if scenario is not None:
            (part / SCENARIO).write_bytes(scenario)
        with _lines(part / TRACE) as trace, _lines(part / EVENTS) as events:
            recorder = Recorder(print_frames(trace), events)
            yield recorder.attach
            recorder.end()


def _lines(path: Path) -> TextIO:
    """Each line is on its way to the disk when it is complete."""
    return path.open("w", buffering=1, encoding="utf-8", newline="\n")


class Recorder:
    """Writes down what is on a bus, and what happens beside; it never acts on either."""

    def __init__(self, trace: Observer, events: TextIO) -> None:
        self._trace = trace
        self._events = events
        self._segment = Segment()
        self._nodes: dict[str, Node] = {}
        self._states: dict[str, State] = {}

    def attach(self, segment: Segment, player: Player | None) -> None:
        """Listen from now on: before a power comes."""
        self._trace(segment, player)
        self._segment = segment
        self._nodes = {node.wire.name: node for node in segment.nodes}
        self._decoder = Decoder(segment.nodes)
        segment.listeners.append(self._hear)

    def end(self) -> None:
        """The run is over."""
        self._note(END)

    def _hear(self, frame: Frame, sender: str) -> None:
        if not sender:
            self._note(HEARD, frame=str(frame))
        for name, node in self._nodes.items():
            if node.state is not self._states.get(name, State.INITIALISING):
                self._states[name] = node.state
                self._note("state", name, state=node.state.lower())
        node = self._nodes.get(sender)
        if node is not None and EMCY.fits(frame, node):
            self._note("emcy", sender, frame=str(frame), words=self._decoder.words(frame))

    def _note(self, kind: str, node: str = "", **fields: object) -> None:
        write_event(self._events, Happening(self._segment.clock.now, kind, node, fields))
