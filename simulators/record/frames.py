"""The frames of a record or of a trace file, one after the other."""

import gzip
from collections.abc import Iterator
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any, NamedTuple

import can
from can.io.generic import BinaryIOMessageReader, TextIOMessageReader
from can.io.player import MESSAGE_READERS

from simulators.clock import microseconds
from simulators.errors import UserError
from simulators.frame import Frame

PACKED = ".gz"
LONGEST_LINE = 1 << 16  # characters


class TimedFrame(NamedTuple):
    """A frame and its moment."""

    tick: int
    """Microseconds."""
    frame: Frame


class Lines(TextIOWrapper):
    """A text whose lines are as long as those of a trace, whatever it is."""

    def __next__(self) -> str:  # type: ignore[override]
        line = self.readline(LONGEST_LINE)
        if len(line) == LONGEST_LINE:
            raise ValueError(f"a line of {LONGEST_LINE} characters or more")
        if not line:
            raise StopIteration
        return line


READERS = {
    suffix: kind
    for suffix, kind in MESSAGE_READERS.items()
    if issubclass(kind, (TextIOMessageReader, BinaryIOMessageReader))
}


def read_frames(path: Path) -> Iterator[TimedFrame]:
    """What a trace file of a format of python-can holds, packed or not, without error frames.

    Raises:
        UserError: it is no trace file, or it cannot be read; only when the frames are taken.
    """
    suffixes = [suffix.lower() for suffix in path.suffixes if suffix != PACKED]
    if not suffixes or suffixes[-1] not in READERS:
        raise UserError(f"{path} is no trace file: its name ends in {', '.join(READERS)}")
    if not path.is_file():
        raise UserError(f"{path} is not there")
    kind = READERS[suffixes[-1]]
    try:
        with _opened(path) as packed:
            file: Any = Lines(packed, "utf-8") if issubclass(kind, TextIOMessageReader) else packed
            yield from (_sent(each) for each in kind(file) if not each.is_error_frame)
    except Exception as damage:  # whatever a reader of python-can stumbles over
        reason = str(damage) or type(damage).__name__
        raise UserError(f"{path} cannot be read as {suffixes[-1]}: {reason}") from damage


def _opened(path: Path) -> IO[bytes]:
    return gzip.open(path) if path.suffix == PACKED else path.open("rb")  # type: ignore[return-value]


def _sent(message: can.Message) -> TimedFrame:
    remote, extended = message.is_remote_frame, message.is_extended_id
    frame = Frame(message.arbitration_id, bytes(message.data), remote, extended)
    return TimedFrame(microseconds(message.timestamp), frame)
