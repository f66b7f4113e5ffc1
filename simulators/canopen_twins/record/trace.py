"""Trace files that are written during a run, in the formats of python-can."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import can
from can.io.generic import MessageWriter, TextIOMessageWriter

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import message_of
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.files.whole import file_part, live_file
from canopen_twins.scenario import Player

CHANNEL = "can0"
BINARY = ".blf"  # in pieces of 128 KiB
Observer = Callable[[Segment[Node], Player | None], None]
"""Called before a run begins, with the bus and who plays the scenario on it, if there is one."""


class TimedFrame(NamedTuple):
    """A frame and its moment."""

    tick: int
    """Microseconds."""
    frame: Frame


@contextmanager
def trace_file(path: Path, live: bool = False) -> Iterator[Observer]:
    """Writes every frame of a bus to a file, with the seconds of the bus as its time.

    What twins send goes out (Tx), everything else comes in (Rx). A `live` one is written as it
    goes, so that others can read along: text is in the file itself at once, not only at the end.

    Raises:
        UserError: a suffix that stands for no format, or a file that cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in WRITERS:
        raise UserError(f"{path} is no trace file: its name ends in {', '.join(WRITERS)}")
    live = live and suffix != BINARY
    with (
        live_file(path) if live else file_part(path) as part,
        WRITERS[suffix](part, path) as writer,
    ):

        def attach(segment: Segment[Node], player: Player | None) -> None:
            names = {node.wire.name for node in segment.nodes}

            def hear(frame: Frame, sender: str) -> None:
                writer.on_message_received(_message(frame, segment.clock.now, sender not in names))
                if live and isinstance(writer, TextIOMessageWriter):
                    writer.file.flush()

            segment.listeners.append(hear)

        yield attach


def _message(frame: Frame, time: float, heard: bool) -> can.Message:
    return message_of(frame, timestamp=time, is_rx=heard, channel=CHANNEL)


def _asc(part: Path, path: Path) -> MessageWriter:
    """Vector's text format; python-can would begin it with the date of today."""
    writer = can.ASCWriter(part)
    writer.file.seek(0)
    writer.file.truncate()
    writer.file.write(
        "date Thu Jan 01 00:00:00.000 1970\n"
        "base hex  timestamps absolute\n"
        "internal events logged\n"
        "Begin Triggerblock Thu Jan 01 00:00:00.000 1970\n"
        " 0.000000 Start of measurement\n"
    )
    writer.header_written = True
    return writer


def _blf(part: Path, path: Path) -> MessageWriter:
    """Vector's binary format; python-can would count time from the first frame on."""
    writer = can.BLFWriter(part)
    writer.start_timestamp = 0.0
    return writer


class Trc(can.TRCWriter):
    """PEAK's text format, version 2.1; python-can would leave remote frames out."""

    def __init__(self, part: Path, path: Path) -> None:
        super().__init__(part)
        self.filepath = str(path.name)  # stands in the file
        self.first_timestamp = 0.0
        self.write_header(0.0)

    def on_message_received(self, msg: can.Message) -> None:
        """Take one frame."""
        if not msg.is_remote_frame:
            super().on_message_received(msg)
            return
        width = 7 if msg.is_extended_id else 4
        told = self.FORMAT_MESSAGE.replace(" DT ", " RR ").format(
            msgnr=self.msgnr,
            time=msg.timestamp * 1000,
            channel=self.channel,
            id=f"{msg.arbitration_id:0{width}X}",
            dir="Rx" if msg.is_rx else "Tx",
            dlc=msg.dlc,
            data="",
        )
        self.msgnr += 1
        self.log_event(told, msg.timestamp)


WRITERS: Mapping[str, Callable[[Path, Path], MessageWriter]] = {
    ".log": lambda part, _: can.CanutilsLogWriter(part, channel=CHANNEL),
    ".asc": _asc,
    ".blf": _blf,
    ".trc": Trc,
}
"""From the part that is written and the path it will have."""
