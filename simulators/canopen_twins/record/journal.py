"""events.jsonl of a record: what happened beside the frames, one JSON object a line."""

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.errors import UserError
from canopen_twins.scenario import Player, PlayerEvent
from canopen_twins.scenario.frame_matchers import EmcyLike
from canopen_twins.slave.service import State

LONGEST_LINE = 1 << 20  # characters
FOREVER = 1e9  # seconds; no run is longer
HEARD, STATE, ORDER, STALL, END = "heard", "state", "order", "stall", "end"
EMCY = EmcyLike()
PHRASES = {
    HEARD: "heard {frame}",
    STATE: "{state}",
    ORDER: "ordered: {order} {arguments}",
    STALL: "late: what is periodic is sent once",
    END: "the run is over",
    "emcy": "{words}",
    "step": "step of line {line}: {what}",
    "inject": "fault {fault}({parameters}) injected",
    "clear": "fault {fault} cleared",
    "outcome": "{verdict} of line {line}: {what}: {seen}",
}


class EventLine(NamedTuple):
    """One line."""

    time: float
    """Seconds of the run."""
    kind: str
    node: str
    """Whom it is about; empty for the bus."""
    fields: Mapping[str, Any]

    def __str__(self) -> str:
        fields = dict(self.fields)
        if isinstance(parameters := fields.get("parameters"), Mapping):  # as one would write them
            fields["parameters"] = ", ".join(f"{key}={value}" for key, value in parameters.items())
        try:
            told = PHRASES[self.kind].format(**fields)
        except KeyError:  # a record of tomorrow, or of somebody else
            told = f"{self.kind} {json.dumps(self.fields)}"
        return f"{self.time:12.6f}  {self.node or '-':10}  {told}"


def read_events(path: Path) -> Iterator[EventLine]:
    """Every line of a file.

    Raises:
        UserError: the file cannot be read, or a line of it is none of ours.
    """
    try:
        with path.open(encoding="utf-8") as file:
            for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), ""), 1):
                yield _event(f"{path}:{number}", line)
    except (OSError, UnicodeError) as failure:
        reason = getattr(failure, "strerror", None) or "no UTF-8"
        raise UserError(f"{path}: {reason}") from failure


def _event(where: str, line: str) -> EventLine:
    try:
        fields = json.loads(line)
        time, kind, node = fields.pop("time"), fields.pop("kind"), fields.pop("node")
        if not (isinstance(kind, str) and isinstance(node, str) and 0 <= time < FOREVER):
            raise TypeError
        return EventLine(time, kind, node, fields)
    except (ValueError, TypeError, AttributeError, KeyError, RecursionError):
        raise UserError(f"{where} is damaged: it is no event") from None


class Journal:
    """Writes down what happens on a segment beside the frames; it never acts on it."""

    def __init__(self, file: TextIO, segment: Segment[Node], player: Player | None) -> None:
        self._file = file
        self._clock = segment.clock
        self._nodes = {node.wire.name: node for node in segment.nodes}
        self._decoder = Decoder(segment.nodes)
        self._hear_states = {name: partial(self._hear_state, name) for name in self._nodes}
        segment.listeners.append(self._hear)
        segment.order_listeners.append(self._hear_order)
        segment.clock.stall_listeners.append(self._hear_stall)
        self._unseen = 0.0  # what has been told
        for name, node in self._nodes.items():
            node.listeners.append(self._hear_states[name])
        if player is not None:
            player.listeners.append(self._hear_player)

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

    def _hear_order(self, name: str, word: str, arguments: Sequence[Any]) -> None:
        if self._clock.unseen > self._clock.ticks:  # before what may depend on it
            self._hear_stall(self._clock.unseen)
        self._note(ORDER, name, order=word, arguments=arguments)

    def _hear_stall(self, unseen: float) -> None:
        if unseen != self._unseen:
            self._unseen = unseen
            self._note(STALL, unseen=unseen)

    def _hear_state(self, name: str, state: State) -> None:
        self._note(STATE, name, state=state.lower())

    def _hear_player(self, event: PlayerEvent) -> None:
        if event.kind != STATE:  # nodes tell their states themselves
            self._note(event.kind, event.node, **event.fields)

    def _note(self, kind: str, node: str = "", **fields: object) -> None:
        line = {**fields, "time": self._clock.now, "kind": kind, "node": node}
        self._file.write(json.dumps(line, sort_keys=True, default=str) + "\n")
