"""The verb `expect`: what should be seen, and within which time."""

from collections.abc import Callable, Mapping
from math import inf

from simulators.documents.document import Item
from simulators.replay.expect import Expectation
from simulators.replay.rehearsal import Rehearsal
from simulators.replay.signs import (
    AnyFrame,
    EmcyLike,
    FrameLike,
    HeartbeatLike,
    Holds,
    Range,
    Text,
)
from simulators.replay.targets import Target
from simulators.services import State
from simulators.wire import pattern

NONE = "none"
HEARTBEATS: Mapping[str, State] = {
    state.lower(): state for state in (State.OPERATIONAL, State.PRE_OPERATIONAL, State.STOPPED)
}
EMCY_FIELDS: Mapping[str, int] = {"code": 0xFFFF, "register": 0xFF, "detail": 0xFF_FFFF_FFFF}


def parse_expect(item: Item, rehearsal: Rehearsal) -> Expectation:
    """One kind, and the seconds it may take: `{emcy: none, within: 0.5}`."""
    fields = item.fields((), (*KINDS, "within"))
    kind = item.choice("expect", fields, KINDS)
    if "within" not in fields and kind != "value":
        item.problems.add(item.mark, "'within' is missing: the seconds it may take")
    within = fields["within"].seconds if "within" in fields else 0.0
    with fields[kind].blamed():
        return KINDS[kind](fields[kind], within, rehearsal)


def parse_emcy(item: Item, within: float, rehearsal: Rehearsal) -> Expectation:
    """`{code: 0x2300, register: 0x03, detail: 0x23}` or some of it; `none`."""
    if not item.is_mapping:
        item.one_of("EMCY", [NONE])
        return Expectation(EmcyLike(), within, never=True)
    fields = item.fields((), EMCY_FIELDS) if item.some_pairs else {}
    told = {name: field.whole_up_to(EMCY_FIELDS[name]) for name, field in fields.items()}
    return Expectation(EmcyLike(**told), within)


def parse_frame(item: Item, within: float, rehearsal: Rehearsal) -> Expectation:
    """`185#3C05xxxxxxxxxxxx`."""
    pattern(item.text)
    return Expectation(FrameLike(item.text.strip().replace(".", "").upper()), within)


def parse_heartbeat(item: Item, within: float, rehearsal: Rehearsal) -> Expectation:
    """`operational`; `none`."""
    state = item.one_of("heartbeat", [*HEARTBEATS, NONE])
    if state == NONE:
        return Expectation(HeartbeatLike(), within, never=True)
    return Expectation(HeartbeatLike(HEARTBEATS[state]), within)


def parse_silence(item: Item, within: float, rehearsal: Rehearsal) -> Expectation:
    """`true`."""
    item.one_of("silence", ["true"])
    return Expectation(AnyFrame(), within, never=True)


def parse_value(item: Item, within: float, rehearsal: Rehearsal) -> Expectation:
    """`{Actual voltage: 1340}`, `{0x2020: {is: 9, tolerance: 2}}`, `{0x2020: {min: 1, max: 9}}`."""
    wanted = []
    for pair in item.some_pairs.values():
        with item.problems.at(pair.key):
            target = rehearsal.targets.find(pair.key)
            wanted.append((target, _wanted(target, pair.value)))
    return Expectation(Holds(tuple(wanted)), within)


def _wanted(target: Target, item: Item) -> Range | Text:
    if target.is_text:
        return Text(item.text)
    if not item.is_mapping:
        return Range(item.number, item.number, _is_hexadecimal(item))
    fields = item.fields((), ("is", "tolerance", "min", "max"))
    low, high = _ends(item, {key: field.number for key, field in fields.items()})
    if low > high:
        raise item.wrong(f"no value is in {low}..{high}")
    return Range(low, high, any(map(_is_hexadecimal, fields.values())))


def _ends(item: Item, numbers: Mapping[str, float]) -> tuple[float, float]:
    if "is" in numbers and not numbers.keys() & {"min", "max"}:
        width = numbers.get("tolerance", 0)
        return numbers["is"] - width, numbers["is"] + width
    if numbers and not numbers.keys() & {"is", "tolerance"}:
        return numbers.get("min", -inf), numbers.get("max", inf)
    raise item.wrong("wanted is {is: 5}, {is: 5, tolerance: 1}, {min: 4} or {max: 6} or both")


def _is_hexadecimal(item: Item) -> bool:
    return item.text.startswith("0x")


KINDS: Mapping[str, Callable[[Item, float, Rehearsal], Expectation]] = {
    "emcy": parse_emcy,
    "value": parse_value,
    "frame": parse_frame,
    "heartbeat": parse_heartbeat,
    "silence": parse_silence,
}
