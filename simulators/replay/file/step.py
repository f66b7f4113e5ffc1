"""A step of a scenario: when, which node, and what is done."""

from typing import Annotated, ClassVar

from pydantic import Field, Tag

from simulators.documents.document import Item
from simulators.documents.rules import Apart, Beside, OneOf, Rule
from simulators.documents.table import Table
from simulators.replay.file.leaves import (
    WORD_OR_TABLE,
    Name,
    Named,
    OneFrame,
    Parameters,
    Scalar,
    Seconds,
    SomeSeconds,
    Text,
    abort_code,
    whole,
    word,
)
from simulators.replay.file.signs import MOST_TIMES, Condition, Expect, Values
from simulators.replay.signs import COMMANDS
from simulators.replay.words import SWITCHES

VERBS = ("set", "write", "read", "send", "nmt", "power", "inject", "clear", "expect")
MOMENTS = ("at", "after", "when")

Faults = Annotated[
    Annotated[Name, Tag("word")] | Annotated[Named[Parameters], Tag("table")], WORD_OR_TABLE
]


class AnyStep(Table):
    """What is done, and to which node; a step of the cleanup says no more than this."""

    rules: ClassVar[tuple[Rule, ...]] = (
        OneOf("to do", VERBS),
        Beside("abort", ("write", "read")),
        Beside("timeout", ("write", "read")),
        Beside("for", ("inject",)),
        Beside("until", ("inject",)),
        Apart(("for", "until")),
        Beside("every", ("times",)),
        Beside("times", ("every",)),
    )

    after: Seconds | None = None
    """Seconds after the step above has been carried out, the last time if it is repeated."""
    every: SomeSeconds | None = None
    """Seconds from one repetition to the next; how many there are says `times`."""
    times: Annotated[Item, whole(1, MOST_TIMES)] | None = None
    """How often it is carried out altogether, the first time at its moment."""
    node: Name | None = None
    """The node it is about; may be left out where there is one node, and beside `send`."""
    note: Text | None = None
    """Why it is there; free text, shown where something did not come as expected."""
    set: Named[Scalar] | None = None
    """Changes settings that may change while the device runs, such as its load."""
    write: Named[Scalar] | None = None
    """Writes objects by SDO, one after the other, as a master does."""
    read: Values | None = None
    """Reads objects by SDO, one after the other, and compares what they have."""
    abort: Annotated[Item, abort_code()] | None = None
    """The abort code with which the one object is refused; `none`: it is not answered."""
    timeout: SomeSeconds | None = None
    """Seconds the master waits for each answer; 1 if it is left out."""
    send: OneFrame | None = None
    """Puts a frame on the bus, as cansend writes it."""
    nmt: Annotated[Item, word("NMT command", COMMANDS)] | None = None
    """Commands the node as the NMT master."""
    power: Annotated[Item, word("position of the supply", SWITCHES)] | None = None
    """Switches the supply of the node on or off."""
    inject: Faults | None = None
    """Lets something go wrong: a fault by its name, with parameters if it has some."""
    lasts: SomeSeconds | None = Field(None, alias="for")
    """Seconds after which the fault is cleared."""
    until: Condition | None = None
    """What happens when the fault is cleared."""
    clear: Name | None = None
    """Takes a fault away, or `all` of them."""
    expect: Expect | None = None
    """Watches, and decides."""


class Step(AnyStep):
    """What is done, to which node, and when."""

    rules = (OneOf("says when", MOMENTS), *AnyStep.rules)

    at: Seconds | None = None
    """Seconds since the beginning; steps stand in the order of their times."""
    when: Condition | None = None
    """At the moment it happens; watched for from the step above on."""
