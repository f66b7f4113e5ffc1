"""A file as values that know their place in it, and say what is wrong with them."""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import yaml

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.problems import Mistake, Noted, Problems
from canopen_twins.files.yaml_nodes import Scalar, compose, read_text, scalar

LONGEST_TIME = 86_400  # seconds: a day

Meaning = TypeVar("Meaning")


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

    @contextmanager
    def blamed(self) -> Iterator[None]:
        """What goes wrong inside and knows no place is a mistake at this one."""
        try:
            yield
        except (Mistake, Noted):
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
        value = self.value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
            raise self.wrong(f"{self.text!r} is no number; numbers look like 16, 0x10 or 0.5")
        return value

    @property
    def whole(self) -> int:
        """One whole number."""
        if not isinstance(value := self.number, int):
            raise self.wrong(f"{self.text} is no whole number, such as 16 or 0x10")
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
        if not 0 <= self.number <= LONGEST_TIME:
            raise self.wrong(f"{self.text} s is not in 0..{LONGEST_TIME} s")
        return float(self.number)

    def whole_up_to(self, highest: int) -> int:
        """One whole number out of a range that begins with 0."""
        if not 0 <= self.whole <= highest:
            raise self.wrong(f"{self.text} is not in 0..{highest:#x}")
        return self.whole

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
            raise self.wrong("a key with a value is wanted here, such as {key: value}")
        pairs: dict[str, Pair] = {}
        for nodes in self.node.value:
            pair = Pair(*(Item(node, self.problems) for node in nodes))
            with self.problems.at(pair.key):
                first = pairs.setdefault(pair.key.text, pair)
                if first is not pair:
                    again = f"{pair.key.text!r} stands here twice, first in line {first.key.line}"
                    raise pair.key.wrong(f"{again}; leave one of them out")
        return pairs

    @property
    def content(self) -> Any:
        """All that there is below it, without places."""
        if self.is_mapping:
            return {pair.key.value: pair.value.content for pair in self.pairs.values()}
        if isinstance(self.node, yaml.SequenceNode):
            return [item.content for item in self.items]
        return self.value

    def one_of(self, what: str, known: Collection[str]) -> str:
        """One word out of several."""
        with self.blamed():
            if self.text not in known:
                raise unknown(what, self.text, known)
        return self.text

    @property
    def _scalar(self) -> yaml.ScalarNode:
        if not isinstance(self.node, yaml.ScalarNode):
            raise self.wrong("one value is wanted here, not several")
        return self.node


def read(path: Path, problems: Problems) -> Item:
    """The outermost value of a file.

    Raises:
        DocumentError: it cannot be read, is too large, or is no YAML.
    """
    text = read_text(path)
    try:
        return Item(compose(text), problems)
    except Mistake as mistake:
        problems.add(mistake.mark, str(mistake))
        problems.settle()
        raise


def understand(path: Path, mean: Callable[[Item], Meaning]) -> Meaning:
    """What a file means; `mean` may note what is wrong as problems, and go on.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    problems = Problems(str(path))
    with problems.at(item := read(path, problems)):
        meaning = mean(item)
    problems.settle()
    return meaning


def values(
    table: Item, known: Mapping[str, Callable[[Item], Any]], optional: Collection[str] = ()
) -> dict[str, Any]:
    """What stands behind the keys; notes as problems which are unknown, missing or wrong.

    Args:
        table: Keys with their values.
        known: Takes what stands behind each of the keys there may be; may raise `UserError`.
        optional: Those that may be left out.

    Raises:
        Noted: something was wrong.
    """
    taken = {}
    for name, pair in table.pairs.items():
        with table.problems.at(pair.place(known)):
            if name not in known:
                raise unknown("key", name, known)
            taken[name] = known[name](pair.value)
    missing = [name for name in known if name not in {*table.pairs, *optional}]
    with table.problems.at(table):
        if missing:
            verb = "is" if len(missing) == 1 else "are"
            raise UserError(f"{', '.join(map(repr, missing))} {verb} missing")
    if missing or len(taken) < len(table.pairs):
        raise Noted
    return taken
