"""What a step can do: a verb is a function that reads it, its action, and an entry in VERBS."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from simulators.documents.document import Item
from simulators.node import Node
from simulators.replay.actions import Clear, Inject, Nmt, Power, Send, Set
from simulators.replay.rehearsal import Rehearsal
from simulators.replay.scenario import Action
from simulators.replay.signs import COMMANDS
from simulators.replay.verb_expect import parse_expect
from simulators.replay.verb_write import parse_write
from simulators.wire import Frame

SWITCHES: Mapping[str, Callable[[Node], None]] = {"on": Node.power_on, "off": Node.power_off}
ALL_FAULTS = "all"


def parse_set(item: Item, rehearsal: Rehearsal) -> Action:
    """`{load: open}`."""
    return Set(rehearsal.set(item))


def parse_send(item: Item, rehearsal: Rehearsal) -> Action:
    """`080#`."""
    return Send(Frame.parse(item.text))


def parse_nmt(item: Item, rehearsal: Rehearsal) -> Action:
    """`start`."""
    return Nmt(COMMANDS[item.one_of("NMT command", COMMANDS)])


def parse_power(item: Item, rehearsal: Rehearsal) -> Action:
    """`off`."""
    return Power(SWITCHES[item.one_of("position of the supply", SWITCHES)])


def parse_inject(item: Item, rehearsal: Rehearsal) -> Action:
    """`interlock_open`, or with parameters `{mains: {volts: 300}}`."""
    if not item.is_mapping:
        return Inject({item.text: rehearsal.inject(item, {})})
    faults = {}
    for name, pair in item.some_pairs.items():
        with item.problems.at(pair.value):
            faults[name] = rehearsal.inject(pair.key, pair.value.pairs)
    return Inject(faults)


def parse_clear(item: Item, rehearsal: Rehearsal) -> Action:
    """`interlock_open` or `all`."""
    fault = None if item.text == ALL_FAULTS else item.text
    rehearsal.clear(fault)
    return Clear(fault)


class Verb(NamedTuple):
    """How a verb is read."""

    parse: Callable[..., Action]
    """Called with the value of its key, a rehearsal, and by name what stands beside."""
    beside: tuple[str, ...] = ()
    """Keys of the step that belong to it and may be left out."""


VERBS: Mapping[str, Verb] = {
    "set": Verb(parse_set),
    "write": Verb(parse_write, ("abort",)),
    "send": Verb(parse_send),
    "nmt": Verb(parse_nmt),
    "power": Verb(parse_power),
    "inject": Verb(parse_inject),
    "clear": Verb(parse_clear),
    "expect": Verb(parse_expect),
}
