"""Records a run while it goes on: a folder with all that it takes to live through it again."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TextIO

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.files.whole import folder_part
from canopen_twins.record.about import About
from canopen_twins.record.events import END, HEARD, STATE, EventLine, write_event
from canopen_twins.record.trace import Observer
from canopen_twins.scenario import Player, PlayerEvent, print_frames
from canopen_twins.scenario.matchers import EmcyLike
from canopen_twins.slave.service import State

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
            journals: list[Journal] = []

            def attach(segment: Segment[Node], player: Player | None) -> None:
                print_frames(trace)(segment, player)
                journal = Journal(events, segment)
                journals.append(journal)
                if player is not None:
                    player.listeners.append(journal.hear_player)

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


class Journal:
    """Writes down what happens on a segment beside the frames; it never acts on it."""

    def __init__(self, file: TextIO, segment: Segment[Node]) -> None:
        self._file = file
        self._clock = segment.clock
        self._nodes = {node.wire.name: node for node in segment.nodes}
        self._decoder = Decoder(segment.nodes)
        segment.listeners.append(self._hear)
        self._hear_states = {name: partial(self._hear_state, name) for name in self._nodes}
        for name, node in self._nodes.items():
            node.listeners.append(self._hear_states[name])

    def hear_player(self, event: PlayerEvent) -> None:
        """What the scenario does; of states the nodes tell themselves."""
        if event.kind != STATE:
            self._note(event.kind, event.node, **event.fields)

    def end(self) -> None:
        """The run is over."""
        self._note(END)

    def close(self) -> None:
        """Listen no more."""
        for name, node in self._nodes.items():
            node.listeners.remove(self._hear_states[name])

    def _hear(self, frame: Frame, sender: str) -> None:
        if not sender:
            self._note(HEARD, frame=str(frame))
        if sender in self._nodes and EMCY.fits(frame, self._nodes[sender]):
            self._note("emcy", sender, frame=str(frame), words=self._decoder.words(frame))

    def _hear_state(self, name: str, state: State) -> None:
        self._note(STATE, name, state=state.lower())

    def _note(self, kind: str, node: str = "", **fields: object) -> None:
        write_event(self._file, EventLine(self._clock.now, kind, node, fields))
