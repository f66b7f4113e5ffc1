"""Lines of trace files as sniffers write them: candump, Vector's .asc, PEAK's .trc, columns of CSV.

A reader takes the lines of a file one by one and gives a `Line` for a frame, none for a line that
is something else: a comment, an error frame, CAN FD. `ValueError` is for a line that is damaged.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import LONGEST, Frame
from canopen_twins.errors import UserError, unknown

ERROR_FRAME = 1 << 29  # in identifiers of candump
MILLISECONDS = 1_000
HEX, DECIMAL = 16, 10


class Line(NamedTuple):
    """A frame, its microsecond, and the channel it was on; empty where the format has none."""

    tick: int
    frame: Frame
    channel: str


class Reader(ABC):
    """Of one file: what its head has said counts for the lines below."""

    @abstractmethod
    def read(self, line: str) -> Line | None:
        """The frame of a line; raises `ValueError` if the line is damaged."""

    def prepare(self, first: Sequence[str]) -> None:  # noqa: B027 - most need nothing
        """Look at the first lines of the file, before they are read.

        Raises:
            UserError: the file is of no use.
        """


@lru_cache(maxsize=4096)  # heartbeats, requests and values come again and again
def _frame(can_id: int, extended: bool, data: str) -> Frame:
    """Data are hex digits, perhaps in groups, or begin with the R of a remote frame."""
    if can_id >= (1 << 29 if extended else 1 << 11):
        raise ValueError(f"{can_id:X} is no identifier")
    if data[:1] in ("R", "r"):
        return Frame(can_id, remote=True, extended=extended)
    content = bytes.fromhex(data)
    if len(content) > LONGEST:
        raise ValueError(f"{len(content)} bytes of data")
    return Frame(can_id, content, extended=extended)


def _of_length(frame: Frame, length: int) -> Frame:
    """The same; raises `ValueError` if it is not as long as it was told to be."""
    if not frame.remote and len(frame.data) != length:
        raise ValueError(f"{len(frame.data)} bytes of data, not {length}")
    return frame


# candump


LOGGED = re.compile(
    r"\((\d+\.\d+)\) (\S+) ([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(#?)(R?[0-9A-Fa-f]*)(?:_[0-9A-Fa-f])?"
    r"(?: [RT])?"
)
SHOWN = re.compile(
    r"\s*(?:\(([^)]*)\))?\s*(\S+)\s+(?:[RT]X [B-] [E-]\s+)?([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})"
    r"\s+\[(\d+)\]\s*((?:[0-9A-Fa-f]{2}(?:\s|$))*|remote request)\s*(?:'.*'|ERRORFRAME)?\s*"
)
ONE_DAY = 86_400.0  # seconds; times of the day are not so long ago


class Candump(Reader):
    """`candump -l` and `-L`, and what it shows with any -t."""

    def __init__(self) -> None:
        self._differences = False  # -t d
        self._tick = 0

    def prepare(self, first: Sequence[str]) -> None:
        """Differences of times go down now and then, times do not."""
        shown = [found for line in first if (found := SHOWN.fullmatch(line))]
        if shown and not any(found[1] for found in shown):
            raise UserError("its lines have no times: candump needs -l, -L or -t")
        seconds = [_seconds(found[1]) for found in shown if found[1]]
        going_down = any(later < earlier for earlier, later in pairwise(seconds))
        self._differences = going_down and max(seconds) < ONE_DAY

    def read(self, line: str) -> Line | None:
        """A line of either kind; CAN FD and error frames are none."""
        if found := LOGGED.fullmatch(line):
            time, channel, can_id, is_fd, data = found.groups()
            if is_fd or (len(can_id) > 3 and int(can_id, HEX) & ERROR_FRAME):
                return None
            frame = _frame(int(can_id, HEX), len(can_id) > 3, data)
            return Line(round(float(time) * MICROSECONDS), frame, channel)
        return self._shown(line) if line else None

    def _shown(self, line: str) -> Line | None:
        if not (found := SHOWN.fullmatch(line)):
            raise ValueError("no line of candump")
        time, channel, can_id, length, data = found.groups()
        tick = round(_seconds(time or "") * MICROSECONDS)
        self._tick = self._tick + tick if self._differences else tick
        if len(can_id) > 3 and int(can_id, HEX) & ERROR_FRAME:
            return None
        frame = _frame(int(can_id, HEX), len(can_id) > 3, data)
        return Line(self._tick, _of_length(frame, int(length)), channel)


def _seconds(text: str) -> float:
    """A number, or a date with a time."""
    if "-" in text:
        return datetime.fromisoformat(text.strip()).replace(tzinfo=UTC).timestamp()
    return float(text)


# Vector


CLASSIC = re.compile(
    r"(\d+\.\d+)\s+(\d+)\s+([0-9A-Fa-f]+x?)\s+(?:Rx|Tx|TxRq)\s+"
    r"(?:([rR])\b.*|d\s+(\w+)((?:\s+\w+)*).*)"
)
FD = re.compile(
    r"(\d+\.\d+)\s+CANFD\s+(\d+)\s+(?:Rx|Tx|TxRq)\s+([0-9A-Fa-f]+x?)\s+(?:\S+\s+)?([01])\s+[01]"
    r"\s+[0-9A-Fa-f]+\s+(\d+)((?:\s+[0-9A-Fa-f]{2})*)(?:\s.*)?"
)
TIMED = re.compile(r"(\d+\.\d+)\s")
NO_FRAME = re.compile(r".*\b(ErrorFrame|Statistic|Status|Start|J1939TP|log)\b.*", re.IGNORECASE)


class Asc(Reader):
    """With or without a trigger block, times from the beginning or from the line before."""

    def __init__(self) -> None:
        self._base = HEX
        self._relative = False
        self._now = 0.0

    def read(self, line: str) -> Line | None:
        """A frame of classic CAN; the head and events of the bus are none."""
        text = line.strip()
        timed = TIMED.match(text)
        if timed is None:
            self._head(text.lower())
            return None
        time = float(timed[1])
        self._now = time = self._now + time if self._relative else time
        if found := CLASSIC.fullmatch(text):
            _, channel, can_id, remote, length, rest = found.groups()
            size = 0 if remote else int(length, HEX)
            return self._line(can_id, "R" if remote else rest.split()[:size], channel, size)
        if found := FD.fullmatch(text):
            _, channel, can_id, switched, length, data = found.groups()
            if int(length) > LONGEST or switched == "1":
                return None
            return self._line(can_id, data.split(), channel, int(length))
        if NO_FRAME.fullmatch(text) or len(text.split()) < 4:
            return None
        raise ValueError("no line of an .asc")

    def _line(self, can_id: str, data: str | Sequence[str], channel: str, size: int) -> Line:
        number, extended = int(can_id.removesuffix("x"), self._base), can_id[-1] == "x"
        if not isinstance(data, str):
            data = "".join(f"{int(byte, self._base):02X}" for byte in data)
        frame = _of_length(_frame(number, extended, data), size)
        return Line(round(self._now * MICROSECONDS), frame, channel)

    def _head(self, text: str) -> None:
        words = text.split()
        if words[:1] == ["base"]:
            self._base = DECIMAL if "dec" in words else HEX
            self._relative = "relative" in words


# PEAK


class Trc(Reader):
    """Versions 1.0 to 1.3, 2.0 and 2.1."""

    COLUMNS: Mapping[str, str] = {
        "1.0": "N,O,I,l,D",
        "1.1": "N,O,T,I,l,D",
        "1.2": "N,O,B,T,I,l,D",
        "1.3": "N,O,B,T,I,R,l,D",
    }
    FRAMES = frozenset({"Rx", "Tx", "DT", "RR", ""})

    def __init__(self) -> None:
        self._places = self._of(self.COLUMNS["1.0"])

    def _of(self, columns: str) -> Mapping[str, int]:
        return {name.strip(): place for place, name in enumerate(columns.split(","))}

    def read(self, line: str) -> Line | None:
        """A frame of classic CAN; the head and events of the bus are none."""
        text = line.strip()
        if not text or text[0] == ";":
            self._head(text)
            return None
        places = self._places
        words = text.split(maxsplit=len(places) - 1)
        type_ = words[places["T"]] if "T" in places else ""
        if type_ not in self.FRAMES or words[places["I"]] == "FFFFFFFF":
            return None
        length = int(words[places["l" if "l" in places else "L"]])
        rest = words[places["D"]] if len(words) > places["D"] else ""
        remote = type_ == "RR" or rest.startswith("RTR")
        can_id = words[places["I"]]
        told = _frame(int(can_id, HEX), len(can_id) > 4, "R" if remote else rest[: 3 * length])
        frame = _of_length(told, length)
        tick = round(float(words[places["O"]]) * MILLISECONDS)
        return Line(tick, frame, words[places["B"]] if "B" in places else "")

    def _head(self, text: str) -> None:
        name, _, value = text.partition("=")
        if name == ";$FILEVERSION" and value in self.COLUMNS:
            self._places = self._of(self.COLUMNS[value])
        elif name == ";$FILEVERSION" and not value.startswith("2."):
            raise UserError(f"its version {value} is none of 1.0 to 1.3, 2.0 and 2.1")
        elif name == ";$COLUMNS":
            self._places = self._of(value)


# Columns


UNITS = {"time": MICROSECONDS, "ms": MILLISECONDS, "us": 1}
KEYS = (*UNITS, "id", "data", "length", "channel", "extended", "remote")
SEPARATORS = ",;\t"
TRUE = ("1", "true", "yes", "t", "x")


class Csv(Reader):
    """Columns that somebody has named; what stands above the line with their names is left out."""

    def __init__(self, columns: Mapping[str, str]) -> None:
        self._names = columns
        self._unit = next(each for each in UNITS if each in columns)
        self._places: Mapping[str, range] = {}
        self._separator = ","
        self._above: str | None = None  # the line with the names, until it has come
        self._begun = False

    def prepare(self, first: Sequence[str]) -> None:
        """Find the line with the names; columns by numbers need none."""
        if all(name.replace("-", "").isdigit() for name in self._names.values()):
            self._places = {key: _numbers(name) for key, name in self._names.items()}
            self._separator = max(SEPARATORS, key="".join(first[-1:]).count)
            return
        for line in first:
            self._separator = max(SEPARATORS, key=line.count)
            titles = self._words(line)
            places = {key: _named(name, titles) for key, name in self._names.items()}
            if all(places.values()):
                self._places = {key: found for key, found in places.items() if found}
                self._above = line
                return
        raise UserError(f"no line has the columns {', '.join(self._names.values())}")

    def _words(self, line: str) -> list[str]:
        return [word.strip().strip('"') for word in line.split(self._separator)]

    def read(self, line: str) -> Line | None:
        """What stands in the columns."""
        if self._above is not None:
            self._above = None if line == self._above else self._above
            return None
        if not line:
            return None
        words = self._words(line)
        told = {key: " ".join(words[each.start : each.stop]) for key, each in self._places.items()}
        try:
            time = float(told[self._unit])
        except ValueError:
            if self._begun:
                raise
            return None  # names of columns that are known by their numbers
        self._begun = True
        return Line(round(time * UNITS[self._unit]), _told(told), told.get("channel", ""))


def _told(told: Mapping[str, str]) -> Frame:
    """The frame of columns."""
    can_id = told["id"].lower().removeprefix("0x").removesuffix("h")
    number = int(can_id.removesuffix("x"), HEX)
    extended = number > 0x7FF or can_id[-1] == "x" or told.get("extended", "").lower() in TRUE
    if told.get("remote", "").lower() in TRUE:
        return _frame(number, extended, "R")
    data = told["data"].lower().replace("0x", "").replace(".", " ")
    if (length := told.get("length")) is None:
        return _frame(number, extended, data)
    data = "".join(data.split())[: 2 * int(length)]
    return _of_length(_frame(number, extended, data), int(length))


def _named(name: str, titles: Sequence[str]) -> range | None:
    """The place of a title, or of those from one to another."""
    first, _, last = (name, "", name) if name in titles else name.partition("-")
    if first not in titles or (last or first) not in titles:
        return None
    return range(titles.index(first), titles.index(last or first) + 1)


def _numbers(text: str) -> range:
    first, _, last = text.partition("-")
    return range(int(first) - 1, int(last or first))


def columns(text: str) -> Mapping[str, str]:
    """What `--columns` says: time=Timestamp,id=ID,data=D1-D8; `ms` and `us` are times, too.

    Raises:
        UserError: it does not say where time, identifier and data are.
    """
    found: dict[str, str] = {}
    for part in text.split(","):
        key, equals, name = part.partition("=")
        if not equals or not name:
            raise UserError(f"--columns {part}: write it as time=NAME,id=NAME,data=NAME")
        if key.strip() not in KEYS:
            raise unknown("column", key.strip(), KEYS)
        found[key.strip()] = name.strip()
    lacking = [key for key in ("id", "data") if key not in found]
    if not any(unit in found for unit in UNITS):
        lacking.insert(0, "time")
    if lacking:
        raise UserError(f"--columns does not say where {', '.join(lacking)} is")
    return found


READERS: Mapping[str, type[Reader]] = {
    ".log": Candump,
    ".txt": Candump,
    ".asc": Asc,
    ".trc": Trc,
}


def suffixes(others: Iterable[str]) -> str:
    """Of all trace files, in words."""
    return ", ".join(sorted({*READERS, *others}))
