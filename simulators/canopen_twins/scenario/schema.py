"""The keys of scenario and bench files; each value is read once, as what it means.

What has to be asked of a device stays an `Item`: names of nodes, objects, settings and faults, and
their values.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, ClassVar

from pydantic import ConfigDict, Discriminator, Field, Tag

from canopen_twins.bus.clock import Stalls
from canopen_twins.bus.frame import Frame, pattern
from canopen_twins.device.faults import WEATHERS
from canopen_twins.device.node import Node as Twin
from canopen_twins.device.timing import PRESETS
from canopen_twins.files.document import Item
from canopen_twins.files.leaves import (
    BY_NAME,
    HIGHEST,
    File,
    Name,
    Named,
    Number,
    Parameters,
    Scalar,
    Seconds,
    SomeSeconds,
    Text,
    as_it_stands,
    up_to,
    whole,
    word,
)
from canopen_twins.files.table import (
    IfRight,
    Leaf,
    Listed,
    Rule,
    Table,
    apart,
    beside,
    one_of,
    shapes,
    some_of,
)
from canopen_twins.scenario.actions import PATIENCE
from canopen_twins.scenario.frame_matchers import COMMANDS
from canopen_twins.scenario.scenario import EndsWith
from canopen_twins.scenario.sdo_client import ACCEPTED
from canopen_twins.slave.service import State

ANY, NONE, MASTER, ERROR = "any", "none", "master", "error"
STATES: Mapping[str, State] = {state.lower(): state for state in State}
HEARTBEATS: Mapping[str, str] = {
    **{word: state for word, state in STATES.items() if state is not State.INITIALISING},
    ANY: ANY,
}
SWITCHES: Mapping[str, Callable[[Twin], None]] = {"on": Twin.power_on, "off": Twin.power_off}

STATES_FOR_COMMANDS = {
    "operational": ("start",),
    "run": ("start",),
    "stopped": ("stop",),
    "preop": ("pre-operational",),
    "pre_op": ("pre-operational",),
    "preoperational": ("pre-operational",),
    "pre_operational": ("pre-operational",),
    "reset": ("reset-node",),
    "reset_comm": ("reset-communication",),
}
"""What is said for a command that leads there."""
HEX = "[0-9A-Fa-f]"
FRAME = rf"^({HEX}{{3}}|{HEX}{{8}})#(R[0-8]?|({HEX}{{2}}|\.)*)$"
LIKE_A_FRAME = r"^([0-9A-FXa-fx]{3}|[0-9A-FXa-fx]{8})#(R[0-8]?|[0-9A-FXa-fx.]*\*?)$"
ABORT = {"anyOf": [{"enum": [NONE]}, {"type": "integer", "minimum": 1, "maximum": HIGHEST}]}


def _frame_like(item: Item) -> str:
    pattern(item.text)
    return item.text.strip().replace(".", "").upper()


def _abort_code(item: Item) -> int | None:
    if item.text == NONE:
        return None
    if not (code := item.whole_up_to(HIGHEST)):
        raise item.wrong(f"{item.text} is no abort code; they look like 0x06090030")
    return code


OneFrame = Annotated[
    Frame, Leaf(lambda item: Frame.parse(item.text), {"type": "string", "pattern": FRAME})
]
FrameShape = Annotated[str, Leaf(_frame_like, {"type": "string", "pattern": LIKE_A_FRAME})]
Switch = Annotated[Callable[[Twin], None], word("position of the supply", SWITCHES)]
Always = Annotated[str, Leaf(lambda item: item.one_of("silence", ["true"]), {"const": True})]
Command = Annotated[int, word("NMT command", COMMANDS, STATES_FOR_COMMANDS)]
NodeId = Annotated[
    Item,
    as_it_stands(lambda item: item.value, {"type": "integer", "minimum": 1, "maximum": 127}),
]

WORD_OR_TABLE = Discriminator(lambda found: "table" if found.is_mapping else "word")
"""Between what is tagged "word" and what is tagged "table"."""


MOST_TIMES = 100_000
KINDS = ("emcy", "value", "frame", "heartbeat", "state", "nmt_state", "write", "nmt")
EXPECTED = (*KINDS, "silence", "never")
SOMETHING = "empty; at least one key with a value is wanted here"
RANGE = "wanted is {is: 5}, {is: 5, tolerance: 1}, {min: 4} or {max: 6} or both"
WINDOW = "'within' is missing: the seconds it may take, or 'before': what ends the time"


class Emcy(Table):
    """An emergency message; what is not given may be anything."""

    rules = (some_of(("code", "register", "detail"), SOMETHING),)

    code: Annotated[int, up_to(0xFFFF)] | None = None
    """Emergency error code, such as 0x2310."""
    bits: Annotated[int, up_to(0xFF)] | None = Field(None, alias="register")
    """Error register, such as 0x03."""
    detail: Annotated[int, up_to(0xFF_FFFF_FFFF)] | None = None
    """Manufacturer-specific error field as one number, its first byte the lowest."""


class Wanted(Table):
    """Numbers that are meant, both ends included."""

    rules = (shapes(("is", "is tolerance", "min", "max", "min max"), RANGE),)

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
            Annotated[str, word("EMCY", {ANY: ANY, ERROR: ERROR}), Tag("word")]
            | Annotated[Emcy, Tag("table")],
            WORD_OR_TABLE,
        ]
        | None
    ) = None
    """The node sends an EMCY: with these fields, of an `error`, or `any`."""
    frame: FrameShape | None = None
    """The node sends a frame as cansend writes it: x is any digit, * at the end any rest."""
    heartbeat: Annotated[str, word("heartbeat", HEARTBEATS)] | None = None
    """The node sends a heartbeat with this state, or any; the boot-up message is none."""
    value: Values | None = None
    """All of these objects have these values at a look, which leaves no trace on the bus."""
    state: Annotated[State, word("NMT state", STATES)] | None = None
    """The node enters this NMT state; being in it already does not count."""
    nmt_state: Annotated[State, word("NMT state", STATES)] | None = None
    """The node is in this NMT state at a look, which leaves no trace on the bus."""
    write: Values | None = None
    """The master writes these objects, by SDO or RPDO; attempts count, answered or refused."""
    nmt: Command | None = None
    """The master commands the node, or all nodes."""
    sender: Annotated[str, word("sender", {MASTER: MASTER})] | None = Field(None, alias="from")
    """Frames are looked for among those of the master: whatever no node of the file has sent."""


class Never(Sign):
    """One thing that must not be seen."""

    rules = (one_of("to look for", KINDS, "never"), beside("from", ("frame",)))


class Seen(Sign):
    """One thing that is waited for, of a node."""

    rules: ClassVar[tuple[Rule, ...]] = (
        one_of("to wait for", KINDS, "a condition"),
        beside("from", ("frame",)),
    )

    node: Name | None = None
    """Of which node; that of the step if it is left out."""


class Moment(Seen):
    """One thing that is waited for, or that does not come any more."""

    rules = (*Seen.rules, beside("missing", ("frame", "heartbeat")))

    missing: SomeSeconds | None = None
    """It has come, and not again for so many seconds: that is the moment."""


class Condition(Moment):
    """One thing that is waited for, again and again."""

    nth: Annotated[int, whole(1, MOST_TIMES)] = 1
    """Which time it is seen; the first if it is left out."""


class Expect(Sign):
    """One thing that should be seen, or should not, and the time for it."""

    rules = (
        one_of("to expect", EXPECTED),
        beside("from", ("frame", "silence")),
        some_of(("within", "before", "value", "nmt_state", "never"), WINDOW),
    )

    emcy: (
        Annotated[
            Annotated[str, word("EMCY", {NONE: NONE, ANY: ANY, ERROR: ERROR}), Tag("word")]
            | Annotated[Emcy, Tag("table")],
            WORD_OR_TABLE,
        ]
        | None
    ) = None
    """The node sends an EMCY: with these fields, of an `error`, `any`, or `none` at all."""
    heartbeat: Annotated[str, word("heartbeat", {**HEARTBEATS, NONE: NONE})] | None = None
    """The node sends a heartbeat with this state, `any`, or `none` at all."""
    silence: Always | None = None
    """The node sends nothing at all; with `from: master`, the master."""
    never: Never | None = None
    """This must not be seen: within the time, or up to the end of the run."""
    within: Seconds | None = None
    """Seconds from the step on, both ends included."""
    before: Condition | None = None
    """What ends the time, too."""


VERBS = ("set", "write", "read", "send", "nmt", "power", "inject", "clear", "expect")
MOMENTS = ("at", "after", "when")

Faults = Annotated[
    Annotated[Name, Tag("word")] | Annotated[Named[Parameters], Tag("table")], WORD_OR_TABLE
]


class Change(Table):
    """What is done to a node, and to which."""

    node: Name | None = None
    """The node it is about; may be left out where there is one node, and beside `send`."""
    note: Text = ""
    """Why it is there; free text, shown where something did not come as expected."""
    set: Named[Scalar] | None = None
    """Changes settings that may change while it runs; of a file's device also its objects."""
    power: Annotated[Callable[[Twin], None], word("position of the supply", SWITCHES)] | None = None
    """Switches the supply of the node on or off."""
    inject: Faults | None = None
    """Lets something go wrong: a fault by its name, with parameters if it has some."""
    lasts: SomeSeconds | None = Field(None, alias="for")
    """Seconds after which the fault is cleared."""
    until: Condition | None = None
    """What happens when the fault is cleared."""


HEALING: tuple[Rule, ...] = (
    beside("for", ("inject",)),
    beside("until", ("inject",)),
    apart(("for", "until")),
)


class AnyStep(Change):
    """What is done, and to which node; a step of the cleanup says no more than this."""

    rules: ClassVar[tuple[Rule, ...]] = (
        one_of("to do", VERBS),
        beside("abort", ("write", "read")),
        beside("timeout", ("write", "read")),
        *HEALING,
        beside("every", ("times",)),
        beside("times", ("every",)),
    )

    after: Seconds | None = None
    """Seconds after the step above has been carried out, the last time if it is repeated."""
    every: SomeSeconds = 0.0
    """Seconds from one repetition to the next; how many there are says `times`."""
    times: Annotated[int, whole(1, MOST_TIMES)] = 1
    """How often it is carried out altogether, the first time at its moment."""
    write: Named[Scalar] | None = None
    """Writes objects by SDO, one after the other, as a master does."""
    read: Values | None = None
    """Reads objects by SDO, one after the other, and compares what they have."""
    abort: Annotated[int | None, Leaf(_abort_code, ABORT)] = ACCEPTED
    """The abort code with which the one object is refused; `none`: it is not answered."""
    timeout: SomeSeconds = PATIENCE
    """Seconds the master waits for each answer; 1 if it is left out."""
    send: OneFrame | None = None
    """Puts a frame on the bus, as cansend writes it."""
    nmt: Command | None = None
    """Commands the node as the NMT master."""
    clear: Name | None = None
    """Takes a fault away, or `all` of them."""
    expect: Expect | None = None
    """Watches, and decides."""


class Disturbance(Change):
    """What goes wrong beside the steps, at a moment of its own; it need not come."""

    rules = (
        one_of("to go wrong", ("inject", "set", "power"), "a disturbance"),
        one_of("says when", ("at", "when"), "a disturbance"),
        *HEALING,
    )

    at: Seconds | None = None
    """Seconds since the beginning."""
    when: Condition | None = None
    """At the moment it happens; watched for from the beginning on."""


class Whenever(Table):
    """What is expected every time that something is seen."""

    whenever: Moment
    """What has to be seen for it to begin."""
    after: Seconds = 0.0
    """Seconds until what is expected begins; none if it is left out."""
    expect: Expect
    """Watches, and decides; the next time begins when it has."""
    node: Name | None = None
    """The node it is about; may be left out where there is one node."""
    note: Text = ""
    """Why it is there; free text, shown where something did not come as expected."""


class Recovers(Table):
    """What has to be so again when everything has healed, and the time for it."""

    within: SomeSeconds
    """Seconds from the end of `duration` on, or from the end of the boot time of a node then."""
    when: Seen
    """What has to be seen by then; values of objects have to be so at the end of that time."""


class Step(AnyStep):
    """What is done, to which node, and when."""

    rules = (
        one_of("says when", MOMENTS),
        one_of("to do", VERBS, alone="when"),
        *AnyStep.rules[1:],
    )

    at: Seconds | None = None
    """Seconds since the beginning; steps stand in the order of their times."""
    when: Condition | None = None
    """At the moment it happens; watched for from the step above on. Alone, it is waited for."""


MOST_STEPS, MOST_NODES = 10_000, 127
BIT_RATES = 10_000, 1_000_000  # CiA 301, 5.2


Preset = Annotated[str, word("timing", {name: name for name in PRESETS})]


class Node(Table):
    """A device as it is delivered."""

    device: Name
    """Which device, by its name in `canopen-twin list`, or the path of its EDS file from here."""
    node_id: NodeId | None = None
    """The node id it is delivered with, 1..127."""
    timing: Preset | None = None
    """How long things take: that of the file if it is left out."""
    settings: Parameters | None = None
    """How it is delivered and what is around it; see `canopen-twin settings DEVICE`."""


Nodes = Annotated[dict[Name, IfRight[Node]], Field(min_length=1, max_length=MOST_NODES), BY_NAME]


class FileOfNodes(File):
    """What every file with nodes has."""

    timing: Preset | None = None
    """How long things take for its nodes; ideal is no time at all, and the default but of `run`."""


class BenchFile(FileOfNodes):
    """Several twins on one bus."""

    model_config = ConfigDict(title="Bench file")

    nodes: Nodes
    """Who is on the bus, by names of your own."""


class Space(Table):
    """What a hunt tries, beside what the devices declare."""

    faults: Listed[Name] | None = None
    """These and no others, by their names, whatever the weather."""
    without: Listed[Name] | None = None
    """None of these."""
    most: Annotated[int, whole(1, 3)] | None = None
    """How many go wrong in one run at most: 1 in mild weather, 2 in rough, 3 in hostile."""
    settings: Named[Listed[Scalar]] | None = None
    """Values for settings of the nodes that have them, at power-on and, where they may, later."""


class ScenarioFile(FileOfNodes):
    """Twins and what happens to them; it is played and judged."""

    model_config = ConfigDict(title="Scenario")
    rules = (
        one_of("says who takes part", ("node", "nodes"), "a scenario"),
        some_of(("steps", "always", "recovers"), "'steps' is missing"),
        beside("always", ("steps", "duration")),
        beside("recovers", ("duration",)),
    )

    name: Text = ""
    """What happens, in a few words."""
    covers: Listed[Text] | None = None
    """The statements it is about, such as T-193."""
    seed: Annotated[int, whole(0, HIGHEST)] | None = None
    """Where chance begins, for every fault and device that has a `seed` and is given none."""
    duration: Seconds | None = None
    """Seconds that the run lasts at least; without it conditions are waited for another 60 s."""
    ends_with: Annotated[EndsWith, word("end of a run", {str(end): end for end in EndsWith})] = (
        EndsWith.SCENARIO
    )
    """What ends a run with a command beside it (`run ... -- COMMAND`): the one or the other."""
    stalls: Annotated[Stalls, word("way with stalls", {str(each): each for each in Stalls})] = (
        Stalls.SKIP
    )
    """What becomes of periodic messages after a stall, in real time: sent once, or all of them."""
    bit_rate: Annotated[int, whole(*BIT_RATES)] | None = None
    """Bit/s of the simulated bus; frames take no time if it is left out."""
    arbitration: Name | None = None
    """Who is on the bus first where several send at one microsecond: a node, `master`, or the
    lowest `identifier`; as they were sent if it is left out."""
    master: Text | None = None
    """The master that is tested, MODULE:FUNCTION in Python: `play` runs it in simulated time."""
    node: Node | None = None
    """Who takes part, if it is one; its name is that of its device."""
    nodes: Nodes | None = None
    """Who takes part, if it is more than one, by names of your own."""
    steps: Annotated[Listed[IfRight[Step]], Field(max_length=MOST_STEPS)] | None = None
    """What happens, in the order of time; a contract for a hunt may do without."""
    disturbances: Annotated[Listed[IfRight[Disturbance]], Field(max_length=MOST_STEPS)] | None = (
        None
    )
    """What goes wrong meanwhile, each by itself, in any order."""
    always: Annotated[Listed[IfRight[Whenever]], Field(max_length=MOST_STEPS)] | None = None
    """What is expected every time that something is seen, as long as the run lasts."""
    recovers: Recovers | None = None
    """At the end of `duration` every disturbance heals, and the master has to be back in time."""
    weather: Annotated[str, word("weather", {name: name for name in WEATHERS})] = "rough"
    """What `hunt` lets go wrong: mild, rough or hostile."""
    space: Space | None = None
    """More of what `hunt` lets go wrong, or less."""
    cleanup: Annotated[Listed[IfRight[AnyStep]], Field(max_length=MOST_STEPS)] | None = None
    """Steps that are carried out in the end, whatever came of the others."""
