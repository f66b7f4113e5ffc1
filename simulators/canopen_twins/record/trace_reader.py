"""Trace files of anybody, read frame by frame: what is damaged is told and left out."""

import gzip
from collections.abc import Iterator, Mapping
from io import TextIOWrapper
from itertools import chain, islice
from pathlib import Path
from typing import Any, BinaryIO

from can.io.generic import BinaryIOMessageReader, TextIOMessageReader
from can.io.player import MESSAGE_READERS

from canopen_twins.bus.clock import microseconds
from canopen_twins.bus.python_can import frame_of
from canopen_twins.errors import UserError
from canopen_twins.record.trace import TimedFrame
from canopen_twins.record.trace_formats import READERS, Csv, Line, Reader, suffixes

PACKED = ".gz"
LONGEST_LINE = 1 << 16  # characters
ALL = ""  # channels
LOOKED_AT = 1000  # lines, before any is read
TOLD = 5  # damaged lines
OF_PYTHON_CAN = {
    suffix: reader
    for suffix, reader in MESSAGE_READERS.items()
    if issubclass(reader, (TextIOMessageReader, BinaryIOMessageReader)) and suffix not in READERS
}


class Trace:
    """The frames of a file, packed or not, without error frames and CAN FD; read once or again."""

    def __init__(
        self, path: Path, channel: str | None = None, columns: Mapping[str, str] | None = None
    ) -> None:
        """Of several channels one has to be named, or `ALL`; `columns` are those of a CSV.

        Raises:
            UserError: it is no trace file, or not there.
        """
        endings = [suffix.lower() for suffix in path.suffixes if suffix != PACKED]
        self._suffix = endings[-1] if endings else ""
        if self._suffix not in READERS and self._suffix not in OF_PYTHON_CAN:
            raise UserError(f"{path} is no trace file: its name ends in {suffixes(OF_PYTHON_CAN)}")
        if columns and self._suffix != ".csv":
            raise UserError(f"{path} is no .csv: leave --columns out")
        if not path.is_file():
            raise UserError(f"{path} is not there")
        self.path = path
        self._channel = channel
        self._columns = columns
        self._damaged: list[str] = []
        self._damages = 0
        self._found = ""  # the channel of the frames that are taken
        self._others = False

    @property
    def remarks(self) -> list[str]:
        """The lines that could not be read so far."""
        more = self._damages - len(self._damaged)
        told = [f"{self.path}: {more} more lines are damaged"] if more else []
        return [*self._damaged, *told]

    def __iter__(self) -> Iterator[TimedFrame]:
        """Every frame.

        Raises:
            UserError: it cannot be read, no line of it is a frame, or it has several channels.
        """
        count = 0
        self._damaged, self._damages = [], 0
        try:
            with (
                gzip.open(self.path) if self.path.suffix == PACKED else self.path.open("rb") as file
            ):
                for tick, frame, channel in self._lines(file):
                    if channel != self._found and not self._is_ours(channel):
                        continue
                    count += 1
                    yield TimedFrame(tick, frame)
        except UserError as mistake:
            raise UserError(f"{self.path}: {mistake}") from mistake
        except (OSError, EOFError) as failure:
            raise self._unreadable(failure) from failure
        if not count and self._damages:
            raise UserError(f"{self.path} cannot be read as {self._suffix}: {self._damaged[0]}")
        if not count and self._others:
            raise UserError(f"{self.path} has no channel {self._channel}")

    def _unreadable(self, failure: Exception) -> UserError:
        reason = str(failure) or type(failure).__name__
        return UserError(f"{self.path} cannot be read as {self._suffix}: {reason}")

    def _is_ours(self, channel: str) -> bool:
        """Whether frames of a channel that has not been seen before are taken."""
        if self._channel == ALL:
            return True
        if self._channel is not None and channel != self._channel:
            self._others = True
            return False
        if self._found:
            told = f"it has the channels {self._found} and {channel}"
            raise UserError(f"{told}: say which with --channel")
        self._found = channel
        return True

    def _lines(self, file: Any) -> Iterator[Line]:
        if self._columns or self._suffix in READERS:
            reader = Csv(self._columns) if self._columns else READERS[self._suffix]()
            yield from self._read(reader, file)
        else:
            yield from self._by_python_can(file)

    def _read(self, reader: Reader, file: BinaryIO) -> Iterator[Line]:
        with Lines(file, "utf-8", errors="replace") as lines:
            first = [line.rstrip("\r\n") for line in islice(lines, LOOKED_AT)]
            reader.prepare(first)
            rest = (line.rstrip("\r\n") for line in lines)
            for number, line in enumerate(chain(first, rest), 1):
                try:
                    found = reader.read(line)
                except (ValueError, LookupError, OverflowError) as damage:
                    self._damage(number, line, damage)
                    continue
                if found is not None:
                    yield found

    def _damage(self, number: int, line: str, damage: Exception) -> None:
        self._damages += 1
        if self._damages <= TOLD:
            self._damaged.append(f"{self.path}:{number}: left out, {damage}: {line.strip()[:60]!r}")

    def _by_python_can(self, file: Any) -> Iterator[Line]:
        """Whatever its reader stumbles over, what came before it is good."""
        reader = OF_PYTHON_CAN[self._suffix]
        source: Any = Lines(file, "utf-8") if issubclass(reader, TextIOMessageReader) else file
        count = 0
        try:
            for message in reader(source):
                if message.is_error_frame or message.is_fd:
                    continue
                count += 1
                channel = "" if message.channel is None else str(message.channel)
                yield Line(microseconds(message.timestamp), frame_of(message), channel)
        except Exception as damage:
            if not count and self._suffix == ".csv":
                named = "--columns time=NAME,id=NAME,data=NAME"
                raise UserError(f"not the columns of python-can: name them, {named}") from damage
            if not count:
                raise self._unreadable(damage) from damage
            self._damages += 1
            self._damaged.append(f"{self.path}: the rest cannot be read: {damage}")
        finally:
            source.close()


class Lines(TextIOWrapper):
    """A text whose lines are as long as those of a trace, whatever it is."""

    def __next__(self) -> str:  # type: ignore[override]
        line = self.readline(LONGEST_LINE)
        if len(line) == LONGEST_LINE:
            raise OSError(f"a line of {LONGEST_LINE} characters or more")
        if not line:
            raise StopIteration
        return line


def read_frames(path: Path) -> Iterator[TimedFrame]:
    """What a trace file of ours holds; raises `UserError` as `Trace` does, or if it is damaged."""
    trace = Trace(path, ALL)
    yield from trace
    for remark in trace.remarks:
        raise UserError(remark)
