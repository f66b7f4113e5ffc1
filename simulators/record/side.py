"""One of two that are compared: a record, or the frames of a trace file."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from simulators.clock import MICROSECONDS
from simulators.decode import Decoder
from simulators.errors import UserError
from simulators.mischief import connect
from simulators.node import Node
from simulators.record.events import HEARD, EventLine
from simulators.record.frames import TimedFrame, read_frames
from simulators.record.recorded import Recorded
from simulators.segment import Segment

LONGEST_BOOT, GRAIN = 5.0, 0.1  # seconds
TOLD = 5  # events


@dataclass(frozen=True)
class Side:
    """Called `name` in what is told."""

    name: str
    recorded: Recorded | None
    trace: Path

    @classmethod
    def of(cls, name: str, path: Path) -> Side:
        """A record, if it is a directory.

        Raises:
            UserError: it is neither a record nor a file.
        """
        if path.is_dir():
            recorded = Recorded(path)
            return cls(name, recorded, recorded.trace)
        return cls(name, None, path)

    @property
    def frames(self) -> Iterator[TimedFrame]:
        """Raises `UserError` where they cannot be read."""
        return read_frames(self.trace)

    def tell(self, sent: TimedFrame) -> str:
        """A frame with its time, in words as far as the devices are known."""
        words = self._decoder.words(sent.frame)
        return f"{sent.tick / MICROSECONDS:12.6f}  {sent.frame!s:21}  {words}".rstrip()

    def happened(self, tick: int | None) -> tuple[EventLine, ...]:
        """The last events up to a moment, or to the end; what came from outside is no news."""
        last: deque[EventLine] = deque(maxlen=TOLD)
        for event in self.recorded.events if self.recorded else ():
            if tick is not None and event.time * MICROSECONDS > tick:
                break
            if event.kind != HEARD:
                last.append(event)
        return tuple(last)

    @cached_property
    def _decoder(self) -> Decoder:
        """With the dictionaries that the devices of a record have after a boot."""
        segment: Segment[Node] = Segment()
        try:
            for part in self.recorded.about.nodes if self.recorded else ():
                connect(segment, part.create(), part.name)
        except UserError:  # a record of devices that are here no more still has its frames
            return Decoder([])
        for node in segment.nodes:
            node.power_on()
        while segment.clock.now < LONGEST_BOOT and any(
            node.slave is None for node in segment.nodes
        ):
            segment.advance(GRAIN)
        return Decoder(segment.nodes)
