"""What a step of a file does, and what it waits for or expects: a verb or a sign is an entry."""

import re
from collections.abc import Callable, Mapping
from math import inf

from canopen_twins.device.node import Node
from canopen_twins.files.document import Item, Reported
from canopen_twins.scenario import schema
from canopen_twins.scenario.actions import (
    Action,
    Clear,
    Download,
    Expectation,
    Inject,
    Nmt,
    Power,
    Read,
    Send,
    Set,
    Wait,
    Write,
)
from canopen_twins.scenario.frame_matchers import (
    AnyFrame,
    Commanded,
    EmcyLike,
    FrameLike,
    HeartbeatLike,
)
from canopen_twins.scenario.matchers import Condition, Entered, Holds, IsIn, Matcher, Written
from canopen_twins.scenario.rehearsal import Participants, Rehearsal
from canopen_twins.scenario.schema import ANY, NONE
from canopen_twins.scenario.sdo_client import ACCEPTED
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import Anything, Range, Text, Wanted, encode

Values = Mapping[Item, Item | schema.Wanted]

DECIMAL_CODE = re.compile(r"[1-9][0-9]{3}")
"""An error code as manuals print it, but without 0x."""
ALL_FAULTS = "all"


def action_of(step: schema.Change, participants: Participants) -> Action:
    """What a step or a disturbance does; nothing but waiting for one that only waits.

    Raises:
        UserError: what stands behind its verb cannot be done.
    """
    for verb, action in VERBS.items():
        if (value := getattr(step, verb, None)) is not None:
            with step.item_of(verb).blamed():
                return action(value, step, participants)
    if step.place.pairs.keys() & {*VERBS} or "when" not in step.place.pairs:
        raise Reported
    return Wait()


def _node(step: schema.Change, participants: Participants) -> Rehearsal:
    return participants.rehearsal(step.node, step.place)


def _write(values: Mapping[Item, Item], step: schema.AnyStep, participants: Participants) -> Action:
    """`{Run command: 1}`, `{0x1800:02: 253}`; with `abort` the one object is refused."""
    objects, refused = _node(step, participants).objects, _is_refused(step, "write")
    find = objects.find_any if refused else objects.find
    downloads = []
    for name, value in values.items():
        with name.problems.at(name):
            target = find(name.text)
            downloads.append(Download(target, encode(target, value, not refused), value.text))
    return Write(tuple(downloads), step.abort, step.timeout)


def _read(values: Values, step: schema.AnyStep, participants: Participants) -> Action:
    """`{Actual voltage: {min: 5}}`, `{Firmware: any}`; with `abort` the one object is refused."""
    objects, refused = _node(step, participants).objects, _is_refused(step, "read")
    find = objects.find_any if refused else objects.find_readable
    return Read(_wanted(values, find), step.abort, step.timeout)


def _is_refused(step: schema.AnyStep, verb: str) -> bool:
    objects = step.item_of(verb)
    if step.abort != ACCEPTED and len(objects.pairs) > 1:
        raise objects.wrong("one object at a time can be refused; make it several steps")
    return step.abort != ACCEPTED


def _nmt(command: int, step: schema.AnyStep, participants: Participants) -> Action:
    _node(step, participants)
    return Nmt(command)


def _power(
    switch: Callable[[Node], None], step: schema.Change, participants: Participants
) -> Action:
    _node(step, participants)
    return Power(switch)


def _inject(
    faults: Item | Mapping[Item, Mapping[Item, Item]],
    step: schema.Change,
    participants: Participants,
) -> Action:
    node = _node(step, participants)
    lasts: float | Condition | None = step.lasts
    if step.until is not None:
        lasts = condition_of(step.until, step.node, participants)
    told = step.item_of("inject")
    injected = {}
    for name, given in ({faults: {}} if isinstance(faults, Item) else faults).items():
        with name.problems.at(told.pairs[name.text].value if told.is_mapping else name):
            injected[name.text] = node.inject(name, given, heals=lasts is not None)
    return Inject(injected, lasts)


def _clear(name: Item, step: schema.AnyStep, participants: Participants) -> Action:
    fault = None if name.text == ALL_FAULTS else name.text
    _node(step, participants).clear(fault)
    return Clear(fault)


def expectation_of(
    said: schema.Expect, step: schema.AnyStep | schema.Whenever, participants: Participants
) -> Action:
    """What is expected of the node of a step, unless it says of which; raises as `action_of`."""
    node = participants.rehearsal(step.node, said.place)
    before = None if said.before is None else condition_of(said.before, step.node, participants)
    never = bool(said.never or said.silence or NONE in (said.emcy, said.heartbeat))
    return Expectation(_sign(said.never or said, node), said.within, before, never)


VERBS: Mapping[str, Callable[..., Action]] = {
    "set": lambda settings, *step: Set(_node(*step).set(settings)),
    "write": _write,
    "read": _read,
    "send": lambda frame, *_: Send(frame),
    "nmt": _nmt,
    "power": _power,
    "inject": _inject,
    "clear": _clear,
    "expect": expectation_of,
}


# What is waited for or expected


def condition_of(said: schema.Seen, node: Item | None, participants: Participants) -> Condition:
    """At the node that is named there, otherwise at the one given."""
    rehearsal = participants.rehearsal(said.node or node, said.place)
    nth = said.nth if isinstance(said, schema.Condition) else 1
    missing = said.missing if isinstance(said, schema.Moment) else None
    return Condition(_sign(said, rehearsal), rehearsal.name, nth, missing)


def _sign(said: schema.Sign, node: Rehearsal) -> Matcher:
    for kind, sign in SIGNS.items():
        if (value := getattr(said, kind, None)) is not None:
            return sign(value, node, said.sender is not None)
    raise Reported


def _emcy(said: str | schema.Emcy, *_: object) -> Matcher:
    if isinstance(said, str):
        return EmcyLike(of_error=said == schema.ERROR)
    if said.code is not None and DECIMAL_CODE.fullmatch(text := said.item_of("code").text):
        told = f"{text} is decimal, 0x{said.code:04X}: write 0x{text} if you mean that code"
        said.item_of("code").remark(told)
    return EmcyLike(said.code, said.bits, said.detail)


SIGNS: Mapping[str, Callable[..., Matcher]] = {
    "emcy": _emcy,
    "value": lambda values, node, _: Holds(_wanted(values, node.objects.find)),
    "frame": lambda text, _, by_master: FrameLike(text, by_master),
    "heartbeat": lambda state, *_: HeartbeatLike(None if state in (ANY, NONE) else state),
    "silence": lambda _, __, by_master: AnyFrame(by_master),
    "state": lambda state, *_: Entered(state),
    "nmt_state": lambda state, *_: IsIn(state),
    "write": lambda values, node, _: Written(_wanted(values, node.objects.find_any)),
    "nmt": lambda command, *_: Commanded(command),
}
"""Called with what stands behind the key, the node, and whether frames are of the master."""


def _wanted(values: Values, find: Callable[[str], Target]) -> tuple[tuple[Target, Wanted], ...]:
    """Objects with what they should have; what cannot be becomes a problem."""
    found = []
    for name, value in values.items():
        with name.problems.at(name):
            target = find(name.text)
            found.append((target, _meant(target, value)))
    return tuple(found)


def _meant(target: Target, value: Item | schema.Wanted) -> Wanted:
    if isinstance(value, schema.Wanted):
        return _range(target, value)
    if value.text == ANY:
        return Anything()
    if target.is_text:
        return Text(value.text)
    return Range(value.number, value.number, _is_hexadecimal(value))


def _range(target: Target, wanted: schema.Wanted) -> Range:
    if target.is_text:
        raise wanted.place.wrong("one value is wanted here, not several")
    if wanted.exactly is not None:
        width = wanted.tolerance or 0
        low, high = wanted.exactly - width, wanted.exactly + width
    else:
        low = -inf if wanted.low is None else wanted.low
        high = inf if wanted.high is None else wanted.high
    if low > high:
        raise wanted.place.wrong(f"no value is in {low}..{high}")
    given = (pair.value for key, pair in wanted.place.pairs.items() if key in NUMBERS)
    return Range(low, high, any(map(_is_hexadecimal, given)))


NUMBERS = ("is", "tolerance", "min", "max")


def _is_hexadecimal(item: Item) -> bool:
    return item.text.startswith("0x")
