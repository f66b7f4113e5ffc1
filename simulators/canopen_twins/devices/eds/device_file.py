"""The keys of a device file: an EDS, and what moves and goes wrong in its device."""

from keyword import iskeyword
from typing import Annotated

from pydantic import ConfigDict, Field

from canopen_twins.files.document import Item
from canopen_twins.files.leaves import (
    BY_NAME,
    HIGHEST,
    File,
    Name,
    Named,
    SomeSeconds,
    Text,
    as_it_stands,
    up_to,
    whole,
)
from canopen_twins.files.table import (
    IfRight,
    Leaf,
    Listed,
    Rule,
    Table,
    beside,
    one_of,
    some_of,
)
from canopen_twins.files.yaml_nodes import Scalar

LARGEST_NUMBER = 1e18  # no device has it, and arithmetic with it is safe
EVERY = 1.0  # seconds


def _number(item: Item) -> float:
    if abs(number := item.number) > LARGEST_NUMBER:
        raise item.wrong(f"{item.text} is not in {-LARGEST_NUMBER:g}..{LARGEST_NUMBER:g}")
    return float(number)


def _number_or_name(item: Item) -> Scalar:
    return item.value if isinstance(item.value, str) and item.text else _number(item)


def _truth(item: Item) -> bool:
    return item.truth


Number = Annotated[float, Leaf(_number, {"type": "number"})]
Truth = Annotated[bool, Leaf(_truth, {"type": "boolean"})]
Abort = Annotated[int, whole(1, HIGHEST)]
NUMBER_OR_NAME = as_it_stands(_number_or_name, {"type": ["number", "string"]})
Chosen = Annotated[Item, NUMBER_OR_NAME]
"""A number, or the name of a setting."""
Source = Annotated[Item, NUMBER_OR_NAME]
"""A number, the name of a setting, or an object by its name or address."""


class Profile(Table):
    """What its communication does otherwise; what is left out is as CiA 301 has it."""

    segmented: Truth | None = None
    """Whether the SDO server offers segmented transfer."""
    block: Truth | None = None
    """Whether the SDO server offers block transfer."""
    literal_commands: Truth | None = None
    """Whether 2xh, 40h and 80h are the only SDO command bytes known."""
    length_before_access: Truth | None = None
    """Whether a write is checked for its length before it is checked for being allowed."""
    too_long: Abort | None = None
    """Abort code for more data than the object has room for."""
    too_short: Abort | None = None
    """Abort code for less data than the object has room for."""
    no_history_code: Abort | None = None
    """Abort code for an unused entry of 0x1003; it reads 0 without one."""
    store_code: Abort | None = None
    """Abort code for a wrong signature in 0x1010 and 0x1011."""
    transfer_time_out: SomeSeconds | None = None
    """Seconds after which a transfer that nobody continues is aborted."""
    longest_transfer: Annotated[int, whole(1, 1 << 24)] | None = None
    """Bytes a download of an object without a fixed length may carry."""
    first_heartbeat_at_once: Truth | None = None
    """Whether writing 0x1017 sends a heartbeat; the first comes a period later otherwise."""
    tpdo_on_change: Truth | None = None
    """Whether an event-driven TPDO is sent when its content has changed."""
    strict_cob_id: Truth | None = None
    """Whether a new COB-ID needs two writes, bit 31 first."""
    store_signature: Truth | None = None
    """Whether 0x1010 and 0x1011 want their signature; any value does otherwise."""
    restore_at_once: Truth | None = None
    """Whether 0x1011 acts at once; after the next reset otherwise."""


def _is_ordered(item: Item, _: object) -> None:
    """`low` is not above `high`, where both are numbers."""
    ends = [item.pairs[key].value for key in ("low", "high") if key in item.pairs]
    numbers = [end.value for end in ends if isinstance(end.value, (int, float))]
    if len(numbers) == 2 and numbers[0] > numbers[1]:
        raise ends[0].wrong(f"low is {ends[0].text}, above high, which is {ends[1].text}")


ORDERED = Rule(_is_ordered, {})


class SettingTable(Table):
    """Something that is chosen when the device is made, and may change while it runs."""

    rules = (ORDERED,)

    default: Number
    """Its value when nobody says otherwise."""
    low: Number | None = None
    """The least number it takes."""
    high: Number | None = None
    """The greatest."""
    unit: Text = ""
    """Of the number."""
    text: Text = ""
    """What it means."""


KINDS = ("value", "follows", "ramps", "integrates", "counts", "wanders", "replays")


class ValueTable(Table):
    """How the value of an object moves; numbers are those of the object itself."""

    rules = (
        one_of("that it does", KINDS, "a value"),
        beside("time_constant", ("follows",)),
        beside("gain", ("follows", "integrates")),
        beside("offset", ("follows",)),
        beside("rate", ("ramps",)),
        beside("ramps", ("rate",)),
        beside("noise", ("value",)),
        beside("every", ("counts", "wanders", "noise")),
        beside("low", ("integrates", "counts", "wanders")),
        beside("high", ("integrates", "counts", "wanders")),
        beside("wanders", ("low",)),
        beside("wanders", ("high",)),
        beside("from", ("follows", "ramps", "integrates", "counts", "wanders")),
        beside("column", ("replays",)),
        beside("repeat", ("replays",)),
        ORDERED,
    )

    value: Chosen | None = None
    """Is this number, or that of a setting, give or take `noise`."""
    noise: Chosen | None = None
    """How far off it may be, up or down, anew `every` so many seconds."""
    follows: Source | None = None
    """Approaches an object, a setting or a number."""
    time_constant: Chosen | None = None
    """Seconds after which 63 % of the way are done; at once without one."""
    gain: Chosen | None = None
    """By what the other value is multiplied; 1 if it is left out."""
    offset: Chosen | None = None
    """What is added to that."""
    ramps: Source | None = None
    """Goes evenly to what an object, a setting or a number is."""
    rate: Chosen | None = None
    """How far it goes in a second."""
    integrates: Source | None = None
    """Grows each second by what an object, a setting or a number is, times `gain`."""
    counts: Chosen | None = None
    """Grows by this `every` so many seconds; behind `high` comes `low`."""
    wanders: Chosen | None = None
    """Goes up or down by chance, so far at most, `every` so many seconds."""
    every: Chosen | None = None
    """Seconds between two changes, at least 0.01; 1 if it is left out."""
    low: Chosen | None = None
    """The least it can be; the least its type has room for if it is left out."""
    high: Chosen | None = None
    """The greatest it can be; the greatest its type has room for if it is left out."""
    start: Chosen | None = Field(None, alias="from")
    """What it is at power-on; if it is left out what it follows, or what the EDS says."""
    replays: Text | None = None
    """Is what a CSV file has: seconds since power-on, and values."""
    column: Text | None = None
    """The name of the column with the values; the second one if it is left out."""
    repeat: Truth = False
    """Whether it begins anew at the time of the last row; that value stays otherwise."""
    unit: Text = ""
    """Of the number, for reports and pictures."""


class ConditionTable(Table):
    """A comparison; all that is given has to hold."""

    rules = (some_of(("above", "below", "equals"), "wanted is above, below or equals"),)

    above: Source | None = None
    """It is greater than this."""
    below: Source | None = None
    """It is less than this."""
    equals: Source | None = None
    """It is exactly this."""


class EmergencyTable(Table):
    """An EMCY that is active while values are so."""

    code: Annotated[int, whole(1, 0xFFFF)]
    """Emergency error code, such as 0x4210."""
    bits: Annotated[int, up_to(0xFF)] = Field(0x01, alias="register")
    """Bits of the error register; 0x01, the generic error, if it is left out."""
    detail: Annotated[int, up_to(0xFF_FFFF_FFFF)] = 0
    """Manufacturer-specific error field as one number, its first byte the lowest."""
    condition: Named[ConditionTable] = Field(alias="while")
    """Objects, each with what has to be so; all of them together."""


class FaultTable(Table):
    """Something wrong with values, for as long as it is injected."""

    rules = (some_of(("hold", "set", "offset"), "wanted is hold, set or offset"),)

    text: Text
    """What has happened, and what a master should see of it."""
    hold: Listed[Name] | None = None
    """Objects that stand still, and move on from there when it is over."""
    set: Named[Chosen] | None = None
    """Objects that read this, whatever they are behind it."""
    offset: Named[Chosen] | None = None
    """Objects that read so much more than they are."""


def _identifier(item: Item) -> str:
    if not item.text.isidentifier() or iskeyword(item.text):
        raise item.wrong(f"{item.text!r} is no name of a setting; they look like load_current")
    return item.text


Settings = Annotated[
    dict[
        Annotated[Item, as_it_stands(_identifier, {"type": "string"})],
        IfRight[SettingTable],
    ],
    BY_NAME,
]
Many = Field(min_length=1)


class DeviceFile(File):
    """A device: the EDS it has, and what its values do."""

    model_config = ConfigDict(title="Device file")

    eds: Name
    """The path of its EDS, DCF, XDD or XDC file, from here."""
    python: Name | None = Field(None, alias="class")
    """What does all that a file cannot say: `module:Class`, of a module beside this file."""
    title: Text | None = None
    """Maker and name, for lists; what the EDS says if it is left out."""
    profile: Profile | None = None
    """What its communication does otherwise."""
    settings: Settings | None = None
    """Numbers that are chosen when the device is made, by names of your own."""
    values: Annotated[dict[Name, IfRight[ValueTable]], Many, BY_NAME] | None = None
    """How values move, by the names or addresses of objects."""
    emergencies: Annotated[dict[Name, IfRight[EmergencyTable]], Many, BY_NAME] | None = None
    """What is told while values are so, by names of your own."""
    faults: Annotated[dict[Name, IfRight[FaultTable]], Many, BY_NAME] | None = None
    """What can be injected, by names of your own."""
