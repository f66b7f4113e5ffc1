"""What stands in the tables of every kind of file: numbers, times, words, names, the version."""

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, TypeVar

from pydantic import BeforeValidator, Field

from canopen_twins.files.document import LONGEST_TIME, Item
from canopen_twins.files.table import Leaf, Table

Value = TypeVar("Value")

VERSION = 1
HIGHEST = 0xFFFF_FFFF
TIME = {"type": "number", "minimum": 0, "maximum": LONGEST_TIME}
TEXT = ["string", "number", "boolean"]


def word(
    what: str, known: Mapping[str, object], others: Mapping[str, Sequence[str]] | None = None
) -> Leaf:
    """One word out of several, as what it stands for; `others` as of `errors.unknown`."""
    return Leaf(lambda item: known[item.one_of(what, known, others)], {"enum": [*known]})


def whole(low: int, high: int) -> Leaf:
    """A whole number, both ends included."""

    def mean(item: Item) -> int:
        if not low <= (number := item.whole) <= high:
            raise item.wrong(f"{item.text} is not in {low}..{high}")
        return number

    return Leaf(mean, {"type": "integer", "minimum": low, "maximum": high})


def up_to(highest: int) -> Leaf:
    """A whole number from 0 on, its end told in hexadecimal."""
    schema = {"type": "integer", "minimum": 0, "maximum": highest}
    return Leaf(lambda item: item.whole_up_to(highest), schema)


def as_it_stands(check: Callable[[Item], object], schema: Mapping[str, object]) -> Leaf:
    """A value that is one by its looks; what it means says a device."""

    def mean(item: Item) -> Item:
        check(item)
        return item

    return Leaf(mean, schema)


def _some_time(item: Item) -> float:
    if not (seconds := item.seconds):
        raise item.wrong(f"{item.text} s is no time; it has to be more")
    return seconds


Seconds = Annotated[float, Leaf(lambda item: item.seconds, TIME)]
SomeSeconds = Annotated[float, Leaf(_some_time, {**TIME, "exclusiveMinimum": 0})]
Number = Annotated[float, Leaf(lambda item: item.number, {"type": "number"})]
Text = Annotated[str, Leaf(lambda item: item.text, {"type": TEXT})]
Name = Annotated[Item, as_it_stands(lambda item: item.text, {"type": "string"})]
Scalar = Annotated[Item, as_it_stands(lambda item: item.value, {"type": [*TEXT, "null"]})]

BY_NAME = BeforeValidator(lambda table: {pair.key: pair.value for pair in table.pairs.values()})
Parameters = Annotated[dict[Name, Scalar], BY_NAME]
"""Values by their names; there may be none."""
Named = Annotated[dict[Name, Value], Field(min_length=1), BY_NAME]
"""What is told of at least one name."""


def _check_version(version: Item) -> None:
    """Another version is a problem; the rest is looked at all the same."""
    with version.problems.at(version):
        if version.whole != VERSION:
            raise version.wrong(f"version {version.text} is unknown; this program reads {VERSION}")


class File(Table):
    """What every file has."""

    version: Annotated[None, Leaf(_check_version, {"const": VERSION})]
    """Version of the format: 1."""
    note: Text = ""
    """Free text."""
