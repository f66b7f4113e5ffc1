"""A YAML file as values that know their place in it, and everything that is wrong with them."""

import logging
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import yaml

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.convert import PLAIN, TIMES, meant_number
from canopen_twins.files.yaml_nodes import (
    GLUED,
    LOOKS,
    MISSING_SPACE,
    Mistake,
    Scalar,
    compose,
    scalar,
)

log = logging.getLogger(__name__)

LARGEST_FILE = 256 * 1024  # bytes
LONGEST_TIME = 86_400  # seconds: a day

Meaning = TypeVar("Meaning")


class DocumentError(UserError):
    """Everything that is wrong with a file: `lines`, each "file:line:column: what"."""

    def __init__(self, lines: Collection[str]) -> None:
        super().__init__("\n".join(lines))
        self.lines = tuple(lines)


class Reported(UserError):  # noqa: N818 - of the user's, not of ours
    """What is wrong is among the problems already; there is nothing to go on with."""


class Problems:
    """What has been found wrong with a file so far, so that all of it is told at once."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._found: set[tuple[int, int, str]] = set()

    @property
    def none(self) -> bool:
        """Whether nothing has been found."""
        return not self._found

    @property
    def error(self) -> DocumentError:
        """All of them, in the order of the file."""
        places = sorted(self._found)
        return DocumentError([f"{self._file}:{line}:{col}: {text}" for line, col, text in places])

    def add(self, refusal: UserError, place: yaml.Mark) -> None:
        """Take something that is wrong; what knows no place is blamed on this one."""
        mark = refusal.mark if isinstance(refusal, Mistake) else place
        if not isinstance(refusal, Reported):
            self._found.add((mark.line + 1, mark.column + 1, str(refusal)))

    def remark(self, text: str, place: yaml.Mark) -> None:
        """Warn of what stands at a place."""
        log.warning("%s:%d:%d: %s", self._file, place.line + 1, place.column + 1, text)

    @contextmanager
    def at(self, place: "Item") -> Iterator[None]:
        """Take what is wrong inside, and go on behind."""
        try:
            yield
        except UserError as refusal:
            self.add(refusal, place.mark)


class Pair(NamedTuple):
    """A key and its value."""

    key: "Item"
    value: "Item"

    def place(self, known: Collection[str]) -> "Item":
        """What is to blame: the key if it is unknown, otherwise the value."""
        return self.value if self.key.text in known else self.key


class Item:
    """One value of the file. What it is asked for and is not, it raises as a `Mistake`."""

    def __init__(self, node: yaml.Node, problems: Problems) -> None:
        self.node = node
        self.mark = node.start_mark
        self.problems = problems

    def wrong(self, text: str) -> Mistake:
        """A mistake at this place."""
        return Mistake(self.mark, text)

    def remark(self, text: str) -> None:
        """Something that may be meant otherwise; it is told, and taken as it stands."""
        self.problems.remark(text, self.mark)

    @contextmanager
    def blamed(self) -> Iterator[None]:
        """What goes wrong inside and knows no place is a mistake at this one."""
        try:
            yield
        except (Mistake, Reported):
            raise
        except UserError as refusal:
            raise self.wrong(str(refusal)) from refusal

    @property
    def line(self) -> int:
        """Where it begins, from 1."""
        return self.mark.line + 1

    @property
    def is_mapping(self) -> bool:
        """Whether it has keys."""
        return isinstance(self.node, yaml.MappingNode)

    @property
    def is_word(self) -> bool:
        """Whether it is one value, neither a list nor keys."""
        return isinstance(self.node, yaml.ScalarNode)

    @property
    def is_decimal(self) -> bool:
        """Whether it is nothing but digits."""
        return isinstance(self.node, yaml.ScalarNode) and str(self.node.value).isdecimal()

    @property
    def text(self) -> str:
        """One value as it stands in the file."""
        return str(self._scalar.value)

    @property
    def value(self) -> Scalar:
        """One value as what it looks like."""
        return scalar(self._scalar)

    @property
    def number(self) -> int | float:
        """One number."""
        return self._number()

    def _number(self, units: Mapping[str, float] = PLAIN) -> int | float:
        value = self.value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
            raise self.wrong(self._no_number(units))
        return value

    def _no_number(self, units: Mapping[str, float]) -> str:
        if self._scalar.style and any(look.fullmatch(self.text) for look, _ in LOOKS[:2]):
            return f"{self.text!r} stands in quotes and is a text: write {self.text}"
        if hint := meant_number(self.text, units):
            return f"{self.text!r} is no number: {hint}"
        return f"{self.text!r} is no number; numbers look like 16, 0x10 or 0.5"

    @property
    def whole(self) -> int:
        """One whole number."""
        if not isinstance(value := self.number, int):
            raise self.wrong(f"{self.text} is no whole number, such as 16 or 0x10")
        return value

    def whole_up_to(self, highest: int) -> int:
        """One whole number out of a range that begins with 0."""
        if not 0 <= (value := self.whole) <= highest:
            raise self.wrong(f"{self.text} is not in 0..{highest:#x}")
        return value

    @property
    def truth(self) -> bool:
        """One truth value."""
        if not isinstance(value := self.value, bool):
            raise self.wrong(f"{self.text!r} is neither true nor false")
        return value

    @property
    def seconds(self) -> float:
        """A time."""
        if not 0 <= (value := self._number(TIMES)) <= LONGEST_TIME:
            raise self.wrong(f"{self.text} s is not in 0..{LONGEST_TIME} s")
        return float(value)

    def one_of(
        self,
        what: str,
        known: Collection[str],
        others: Mapping[str, Sequence[str]] | None = None,
    ) -> str:
        """One word out of several; `others` as of `errors.unknown`."""
        if (text := self.text) not in known:
            raise self.wrong(str(unknown(what, text, known, others)))
        return text

    @property
    def items(self) -> list["Item"]:
        """The values of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.wrong("a list is wanted here, each value after a dash")
        return [Item(node, self.problems) for node in self.node.value]

    @cached_property
    def pairs(self) -> Mapping[str, Pair]:
        """Keys as they stand in the file, with their values."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self.wrong(self._no_table())
        pairs: dict[str, Pair] = {}
        for nodes in self.node.value:
            key, value = (Item(node, self.problems) for node in nodes)
            try:
                first = pairs.setdefault(key.text, Pair(key, value))
                if first.key is not key:
                    again = f"{key.text!r} stands here twice, first in line {first.key.line}"
                    raise key.wrong(f"{again}; leave one of them out")
            except UserError as refusal:
                self.problems.add(refusal, key.mark)
        return pairs

    def _no_table(self) -> str:
        is_word = isinstance(self.node, yaml.ScalarNode)
        if is_word and (glued := GLUED.fullmatch(str(self.node.value))):
            return MISSING_SPACE.format(*glued.groups())
        return "a key with a value is wanted here, such as {key: value}"

    @property
    def content(self) -> Any:
        """All that there is below it, without places."""
        if self.is_mapping:
            return {pair.key.value: pair.value.content for pair in self.pairs.values()}
        if isinstance(self.node, yaml.SequenceNode):
            return [item.content for item in self.items]
        return self.value

    @property
    def _scalar(self) -> yaml.ScalarNode:
        if not isinstance(self.node, yaml.ScalarNode):
            raise self.wrong("one value is wanted here, not several")
        return self.node


def understand(path: Path, mean: Callable[[Item], Meaning], text: str | None = None) -> Meaning:
    """What a file means; `mean` may put what is wrong among the problems of an item, and go on.

    Args:
        path: Of the file.
        mean: What it means.
        text: What would stand in it; None: what does.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place; the file
            cannot be read, is too large, or is no YAML.
    """
    problems = Problems(path)
    try:
        item = Item(compose(_text(path) if text is None else text), problems)
    except Mistake as mistake:
        problems.add(mistake, mistake.mark)
        raise problems.error from mistake
    with problems.at(item):
        meaning = mean(item)
    if not problems.none:
        raise problems.error
    return meaning


def values(
    table: Item, known: Mapping[str, Callable[[Item], Any]], optional: Collection[str] = ()
) -> dict[str, Any]:
    """What stands behind the keys; keys that are unknown, missing or wrong become problems.

    Args:
        table: Keys with their values.
        known: Takes what stands behind each of the keys there may be; may raise `UserError`.
        optional: Those that may be left out.

    Raises:
        UserError: something was wrong.
    """
    taken = {}
    for name, pair in table.pairs.items():
        with table.problems.at(pair.place(known)):
            if name not in known:
                raise unknown("key", name, known)
            taken[name] = known[name](pair.value)
    missing = [name for name in known if name not in {*table.pairs, *optional}]
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        raise table.wrong(f"{', '.join(map(repr, missing))} {verb} missing")
    if len(taken) < len(table.pairs):
        raise Reported
    return taken


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        text = content.decode("utf-8-sig")
    except OSError as failure:
        raise DocumentError([f"{path}: {failure.strerror}"]) from failure
    except UnicodeDecodeError as failure:
        raise DocumentError([f"{path}: no UTF-8 text"]) from failure
    if len(content) > LARGEST_FILE:
        raise DocumentError([f"{path}: larger than {LARGEST_FILE} bytes"])
    return text
