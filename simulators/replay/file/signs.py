"""What can be seen of a node or of the master: in a condition, in an expectation, or never."""

from typing import Annotated

from pydantic import Field, Tag

from simulators.documents.document import Item
from simulators.documents.rules import Beside, OneOf, Shapes, SomeOf
from simulators.documents.table import Leaf, Table
from simulators.replay.file.leaves import (
    WORD_OR_TABLE,
    FrameShape,
    Name,
    Named,
    Number,
    Scalar,
    Seconds,
    up_to,
    whole,
    word,
)
from simulators.replay.signs import COMMANDS
from simulators.replay.words import ANY, EMCY_FIELDS, HEARTBEATS, MASTER, NONE, STATES

MOST_TIMES = 100_000
KINDS = ("emcy", "value", "frame", "heartbeat", "state", "write", "nmt")
EXPECTED = ("emcy", "value", "frame", "heartbeat", "silence", "state", "write", "nmt", "never")
SOMETHING = "empty; at least one key with a value is wanted here"
RANGE = "wanted is {is: 5}, {is: 5, tolerance: 1}, {min: 4} or {max: 6} or both"
WINDOW = "'within' is missing: the seconds it may take, or 'before': what ends the time"

TRUE = Leaf(lambda item: item.one_of("silence", ["true"]), {"const": True})


class Emcy(Table):
    """An emergency message; what is not given may be anything."""

    rules = (SomeOf(EMCY_FIELDS, SOMETHING),)

    code: Annotated[Item, up_to(EMCY_FIELDS["code"])] | None = None
    """Emergency error code, such as 0x2310."""
    bits: Annotated[Item, up_to(EMCY_FIELDS["register"])] | None = Field(None, alias="register")
    """Error register, such as 0x03."""
    detail: Annotated[Item, up_to(EMCY_FIELDS["detail"])] | None = None
    """Manufacturer-specific error field as one number, its first byte the lowest."""


class Wanted(Table):
    """Numbers that are meant, both ends included."""

    rules = (Shapes(("is", "is tolerance", "min", "max", "min max"), RANGE),)

    exactly: Number | None = Field(None, alias="is")
    """The number itself."""
    tolerance: Number | None = None
    """How far off it may be, up or down."""
    low: Number | None = Field(None, alias="min")
    """The least."""
    high: Number | None = Field(None, alias="max")
    """The greatest."""


Values = Named[
    Annotated[Annotated[Scalar, Tag("word")] | Annotated[Wanted, Tag("table")], WORD_OR_TABLE]
]
"""By the names of objects: a number, a text, a range of numbers, or `any`."""


class Sign(Table):
    """One thing that can be seen."""

    emcy: (
        Annotated[
            Annotated[Item, word("EMCY", [ANY]), Tag("word")] | Annotated[Emcy, Tag("table")],
            WORD_OR_TABLE,
        ]
        | None
    ) = None
    """The node sends an EMCY: with these fields, or `any`."""
    frame: FrameShape | None = None
    """The node sends a frame as cansend writes it: x is any digit, * at the end any rest."""
    heartbeat: Annotated[Item, word("heartbeat", [*HEARTBEATS, ANY])] | None = None
    """The node sends a heartbeat with this state, or any; the boot-up message is none."""
    value: Values | None = None
    """All of these objects have these values at a look, which leaves no trace on the bus."""
    state: Annotated[Item, word("NMT state", STATES)] | None = None
    """The node enters this NMT state; being in it already does not count."""
    write: Values | None = None
    """The master writes these objects, by SDO or RPDO; attempts count, answered or refused."""
    nmt: Annotated[Item, word("NMT command", COMMANDS)] | None = None
    """The master commands the node, or all nodes."""
    sender: Annotated[Item, word("sender", [MASTER])] | None = Field(None, alias="from")
    """Frames are looked for among those of the master: whatever no node of the file has sent."""


class Never(Sign):
    """One thing that must not be seen."""

    rules = (OneOf("to look for", KINDS, "never"), Beside("from", ("frame",)))


class Condition(Sign):
    """One thing that is waited for."""

    rules = (OneOf("to wait for", KINDS, "a condition"), Beside("from", ("frame",)))

    nth: Annotated[Item, whole(1, MOST_TIMES)] | None = None
    """Which time it is seen; the first if it is left out."""
    node: Name | None = None
    """Of which node; that of the step if it is left out."""


class Expect(Sign):
    """One thing that should be seen, or should not, and the time for it."""

    rules = (
        OneOf("to expect", EXPECTED),
        Beside("from", ("frame", "silence")),
        SomeOf(("within", "before", "value", "never"), WINDOW),
    )

    emcy: (
        Annotated[
            Annotated[Item, word("EMCY", [NONE, ANY]), Tag("word")] | Annotated[Emcy, Tag("table")],
            WORD_OR_TABLE,
        ]
        | None
    ) = None
    """The node sends an EMCY: with these fields, `any`, or `none` at all."""
    heartbeat: Annotated[Item, word("heartbeat", [*HEARTBEATS, ANY, NONE])] | None = None
    """The node sends a heartbeat with this state, `any`, or `none` at all."""
    silence: Annotated[Item, TRUE] | None = None
    """The node sends nothing at all; with `from: master`, the master."""
    never: Never | None = None
    """This must not be seen: within the time, or up to the end of the run."""
    within: Seconds | None = None
    """Seconds from the step on, both ends included."""
    before: Condition | None = None
    """What ends the time, too."""
