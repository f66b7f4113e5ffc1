"""What happens on a bus in words, as it happens."""

import os
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from queue import Empty, Full, Queue
from threading import Thread
from typing import TextIO

from canopen_twins.bus import sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.diagnosis.report import SHOWN, frame_line
from canopen_twins.diagnosis.why import why_frame
from canopen_twins.record.journal import EventLine
from canopen_twins.scenario import Player, PlayerEvent
from canopen_twins.scenario.frame_matchers import EmcyLike
from canopen_twins.slave.service import State

MOST_WAITING = 10_000  # lines that nobody has read yet
EMCY = EmcyLike()
COLOURS: Mapping[str, str] = {"refusal": "31", "emcy": "33", "state": "36", "player": "35"}
"""Of a line, as SGR of ECMA-48."""


class Printer:
    """Writes lines in a thread of its own: whoever does not read them holds no twin up."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lines: Queue[str | None] = Queue(MOST_WAITING)
        self._lost = 0
        self._thread = Thread(target=self._write, name="words", daemon=True)

    def start(self) -> None:
        """Write from now on, first what has been put before: the ready line stands above it."""
        self._thread.start()

    def put(self, line: str) -> None:
        """Let a line be written, if there is room; never waits."""
        try:
            self._lines.put_nowait(line)
        except Full:
            self._lost += 1

    def close(self, patience: float = 1.0) -> None:
        """Write what is left, as far as somebody reads it in so many seconds."""
        if not self._thread.is_alive():
            return
        try:
            self._lines.put(None, timeout=patience)
        except Full:
            return
        self._thread.join(patience)

    def _write(self) -> None:
        try:
            while (line := self._lines.get()) is not None:
                print(line, file=self._stream, flush=self._lines.empty())
                if self._lines.empty():
                    self._tell_what_is_lost()
            self._tell_what_is_lost()
        except (OSError, ValueError):  # the reader has gone
            self._drain()

    def _tell_what_is_lost(self) -> None:
        if self._lost:
            lost, self._lost = self._lost, 0
            told = f"{lost} lines were not read in time, and are lost"
            print(told, file=self._stream, flush=True)

    def _drain(self) -> None:
        while True:
            try:
                self._lines.get(timeout=1.0)
            except Empty:
                return


class Words:
    """Tells what happens, a line at a time; `quiet` leaves frames out that are as usual."""

    def __init__(self, put: Callable[[str], None], coloured: bool, quiet: bool) -> None:
        self._put = put
        self._coloured = coloured
        self._quiet = quiet
        self._records: deque[Record] = deque(maxlen=SHOWN)

    def attach(self, segment: Segment[Node], player: Player | None) -> None:
        """Hear a bus, its nodes and the player of a scenario from now on."""
        self._segment = segment
        self._nodes = {node.wire.name: node for node in segment.nodes}
        self._decoder = Decoder(segment.nodes)
        segment.listeners.append(self._hear)
        for name, node in self._nodes.items():
            node.listeners.append(partial(self._hear_state, name))
        if player is not None:
            player.listeners.append(self._hear_player)

    def _hear(self, frame: Frame, sender: str) -> None:
        record = Record(self._segment.clock.now, frame, sender)
        self._records.append(record)
        node = self._nodes.get(sender)
        if node is None:
            kind = ""
        elif sdo.is_answer(frame, node.node_id) and sdo.is_abort(frame.data):
            kind = "refusal"
        else:
            kind = "emcy" if EMCY.fits(frame, node) else ""
        if kind or not self._quiet:
            self._tell(kind, frame_line(record, self._decoder))
        if kind == "refusal" and node is not None:
            for reason in why_frame(node, list(self._records), frame):
                self._tell(kind, f"{'':14}why: {reason}")

    def _hear_state(self, name: str, state: State) -> None:
        now, fields = self._segment.clock.now, {"state": state.lower()}
        self._tell("state", str(EventLine(now, "state", name, fields)))

    def _hear_player(self, event: PlayerEvent) -> None:
        if event.kind != "state":  # nodes tell their states themselves
            line = EventLine(event.time, event.kind, event.node, event.fields)
            self._tell("player", str(line))

    def _tell(self, kind: str, line: str) -> None:
        if self._coloured and kind:
            line = f"\x1b[{COLOURS[kind]}m{line}\x1b[0m"
        self._put(line)


def is_coloured(stream: TextIO, environment: Mapping[str, str] = os.environ) -> bool:
    """Whether somebody looks at it who wants colours (no-color.org)."""
    wanted = not environment.get("NO_COLOR") and environment.get("TERM") != "dumb"
    return wanted and stream.isatty()
