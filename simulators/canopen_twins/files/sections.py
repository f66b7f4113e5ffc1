"""Files of sections `[name]` and lines `key=value`: every value knows its line.

CiA 306 (4.2, 4.3) wants 7-bit ASCII, and comments that begin with `;` in the first column. Tools
write umlauts in three encodings, a byte order mark, keys in any case, sections and keys twice:
all of that is taken, and remarked upon where somebody may have meant something else.
"""

import re
from codecs import charmap_decode
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from canopen_twins.errors import UserError
from canopen_twins.files.whole import read_plain

LARGEST_FILE = 16 * 1024 * 1024
LINE = re.compile(r"\r\n|\n|\r")
HEADER = re.compile(r"\[\s*([^\]]*?)\s*\]\s*(?:[;#].*)?")
COMMENTS = (";", "#")
BYTE_ORDER_MARKS = {b"\xef\xbb\xbf": "utf-8", b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
NO_TEXT = "\0"


class Remark(NamedTuple):
    """Something wrong or unusual in a file, and what is made of it."""

    line: int
    """From 1; 0 for the file as a whole."""
    section: str
    words: str

    def told(self, path: object) -> str:
        """One line: the file, the line, the section, and what is made of it."""
        place = f"{path}:{self.line}" if self.line else str(path)
        return (
            f"{place}: [{self.section}] {self.words}" if self.section else f"{place}: {self.words}"
        )


class Field(NamedTuple):
    """What stands behind a key."""

    text: str
    line: int
    key: str
    """As it is written."""


class Section(Mapping[str, Field]):
    """The fields of a section; case does not matter, and an empty value is none (CiA 306, 4.3)."""

    def __init__(self, name: str, line: int) -> None:
        self.name = name
        self.line = line
        self._fields: dict[str, Field] = {}

    def __getitem__(self, key: str) -> Field:
        return self._fields[key.lower()]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    @classmethod
    def of(cls, name: str, line: int, keys: Mapping[str, str]) -> "Section":
        """A section that a file tells in another way, in one of its lines."""
        section = cls(name, line)
        for key, text in keys.items():
            section.put(key, text, line)
        return section

    def renamed(self, name: str, keys: Mapping[str, str] | None = None) -> "Section":
        """The same by another name, with other texts behind some keys."""
        section = Section(name, self.line)
        section._fields = dict(self._fields)
        for key, text in (keys or {}).items():
            section.put(key, text, self.line)
        return section

    def put(self, key: str, text: str, line: int) -> None:
        """Let a text stand behind a key."""
        self._fields[key.lower()] = Field(text, line, key)

    def text(self, key: str, default: str = "") -> str:
        """What stands behind a key."""
        field = self._fields.get(key.lower())
        return field.text if field and field.text else default

    def take(self, field: Field) -> Field | None:
        """Take a field in; the one of the same key that gives way, if there is one."""
        before = self._fields.get(key := field.key.lower())
        self._fields[key] = field
        return before


class Sections(Mapping[str, Section]):
    """The sections of a file by their names; case does not matter."""

    def __init__(self, text: str) -> None:
        self.remarks: list[Remark] = []
        self._sections: dict[str, Section] = {}
        section: Section | None = None
        for number, line in enumerate(map(str.strip, LINE.split(text)), 1):
            if not line or line.startswith(COMMENTS):
                continue
            if line.startswith("[") and (header := HEADER.fullmatch(line)):
                section = self._begin(header[1], number)
            elif section is None:
                words = f"{_short(line)} stands before the first section: ignored"
                self.remarks.append(Remark(number, "", words))
            else:
                self._read(section, number, line)

    def __getitem__(self, name: str) -> Section:
        return self._sections[name.lower()]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sections)

    def __len__(self) -> int:
        return len(self._sections)

    def section(self, name: str) -> Section:
        """A section by its name; an empty one if there is none."""
        return self._sections.get(name.lower()) or Section(name, 0)

    def add(self, sections: Iterable[Section]) -> None:
        """Add sections whose names are not there yet."""
        for section in sections:
            self._sections.setdefault(section.name.lower(), section)

    def put(self, section: Section) -> None:
        """Add a section in place of the one of its name."""
        self._sections[section.name.lower()] = section

    def remark(self, section: Section, words: str, line: int | None = None) -> None:
        """Remark on a section, or on one of its lines."""
        self.remarks.append(Remark(section.line if line is None else line, section.name, words))

    def _begin(self, name: str, number: int) -> Section:
        section = self._sections.get(name.lower())
        if section is None:
            section = self._sections[name.lower()] = Section(name, number)
        else:
            words = f"is there in line {section.line} already: what stands here holds"
            section.line = number
            self.remark(section, words)
        return section

    def _read(self, section: Section, number: int, line: str) -> None:
        key, equals, text = line.partition("=")
        if not equals:
            self.remark(section, f"{_short(line)} is no KEY=VALUE: ignored", number)
            return
        before = section.take(Field(text.strip(), number, key.strip()))
        if before is not None and before.line >= section.line:
            words = f"{before.key} is there in line {before.line} already: what stands here holds"
            self.remark(section, words, number)


def read_sections(path: Path) -> Sections:
    """Read a file.

    Raises:
        UserError: it cannot be read, is larger than 16 MiB, or is no text.
    """
    content = read_plain(path, LARGEST_FILE)
    text = decoded(content)
    if NO_TEXT in text:
        raise UserError(f"{path} is no text: it has bytes of zero")
    return Sections(text)


def decoded(content: bytes) -> str:
    """The text of a file: by its byte order mark, as UTF-8, or else as Windows-1252.

    The five bytes that Windows-1252 leaves open are those of Latin-1: no byte is lost.
    """
    for mark, encoding in BYTE_ORDER_MARKS.items():
        if content.startswith(mark):
            return content[len(mark) :].decode(encoding, "replace")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return charmap_decode(content, "strict", WINDOWS)[0]


def _windows(byte: int) -> str:
    try:
        return bytes((byte,)).decode("cp1252")
    except UnicodeDecodeError:
        return chr(byte)


WINDOWS = "".join(map(_windows, range(256)))


def _short(line: str) -> str:
    return repr(line if len(line) <= 40 else f"{line[:37]}...")
