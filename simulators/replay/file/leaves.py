"""What stands behind a key: times, numbers, words, frames, and values by name."""

from collections.abc import Collection
from typing import Annotated, TypeVar

from pydantic import BeforeValidator, Discriminator, Field

from simulators.documents.document import LONGEST_TIME, Item
from simulators.documents.table import Leaf
from simulators.frame import Frame, pattern
from simulators.replay.words import NONE

Value = TypeVar("Value")

HIGHEST = 0xFFFF_FFFF
HEX = "[0-9A-Fa-f]"
FRAME = rf"^({HEX}{{3}}|{HEX}{{8}})#(R[0-8]?|({HEX}{{2}}|\.)*)$"
LIKE_A_FRAME = r"^([0-9A-FXa-fx]{3}|[0-9A-FXa-fx]{8})#(R[0-8]?|[0-9A-FXa-fx.]*\*?)$"
TIME = {"type": "number", "minimum": 0, "maximum": LONGEST_TIME}
TEXT = ["string", "number", "boolean"]


def word(what: str, known: Collection[str]) -> Leaf:
    """One word out of several."""
    return Leaf(lambda item: item.one_of(what, known), {"enum": [*known]})


def whole(low: int, high: int) -> Leaf:
    """A whole number, both ends included."""

    def ask(item: Item) -> None:
        if not low <= item.whole <= high:
            raise item.wrong(f"{item.text} is not in {low}..{high}")

    return Leaf(ask, {"type": "integer", "minimum": low, "maximum": high})


def up_to(highest: int) -> Leaf:
    """A whole number from 0 on, its end told in hexadecimal."""
    schema = {"type": "integer", "minimum": 0, "maximum": highest}
    return Leaf(lambda item: item.whole_up_to(highest), schema)


def abort_code() -> Leaf:
    """An SDO abort code, or the word that there is no answer."""
    schema = {"anyOf": [{"enum": [NONE]}, {"type": "integer", "minimum": 1, "maximum": HIGHEST}]}
    return Leaf(_abort_code, schema)


def _abort_code(item: Item) -> None:
    if item.text != NONE and not item.whole_up_to(HIGHEST):
        raise item.wrong(f"{item.text} is no abort code; they look like 0x06090030")


def _some_time(item: Item) -> None:
    if not item.seconds:
        raise item.wrong(f"{item.text} s is no time; it has to be more")


Seconds = Annotated[Item, Leaf(lambda item: item.seconds, TIME)]
SomeSeconds = Annotated[Item, Leaf(_some_time, {**TIME, "exclusiveMinimum": 0})]
Number = Annotated[Item, Leaf(lambda item: item.number, {"type": "number"})]
Text = Annotated[Item, Leaf(lambda item: item.text, {"type": TEXT})]
Scalar = Annotated[Item, Leaf(lambda item: item.value, {"type": [*TEXT, "null"]})]
Name = Annotated[Item, Leaf(lambda item: item.text, {"type": "string"})]
OneFrame = Annotated[
    Item, Leaf(lambda item: Frame.parse(item.text), {"type": "string", "pattern": FRAME})
]
FrameShape = Annotated[
    Item, Leaf(lambda item: pattern(item.text), {"type": "string", "pattern": LIKE_A_FRAME})
]

BY_NAME = BeforeValidator(lambda item: {pair.key: pair.value for pair in item.pairs.values()})
Parameters = Annotated[dict[Name, Scalar], BY_NAME]
"""Values by their names; there may be none."""
Named = Annotated[dict[Name, Value], Field(min_length=1), BY_NAME]
"""What is told of at least one name."""

WORD_OR_TABLE = Discriminator(lambda item: "table" if item.is_mapping else "word")
"""Between what is tagged "word" and what is tagged "table"."""
