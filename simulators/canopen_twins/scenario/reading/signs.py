"""What should be seen, or is waited for: signs with the objects of their node."""

from collections.abc import Callable, Mapping

from canopen_twins.files.document import Item
from canopen_twins.files.problems import Noted
from canopen_twins.scenario import schema as keys
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.matchers import (
    COMMANDS,
    AnyFrame,
    Commanded,
    Condition,
    EmcyLike,
    Entered,
    FrameLike,
    HeartbeatLike,
    Holds,
    Matcher,
    Written,
)
from canopen_twins.scenario.reading.dry_run import DryRun
from canopen_twins.scenario.reading.participants import Participants
from canopen_twins.scenario.reading.values import Told, wanted
from canopen_twins.scenario.words import HEARTBEATS, NONE, STATES


def condition(told: keys.Condition, node: Item | None, participants: Participants) -> Condition:
    """What is waited for, at the node that is named there, otherwise at the one given.

    Raises:
        UserError: no such node, or no such object there.
    """
    dry_run = participants.dry_run(told.node or node, told.place)
    nth = 1 if told.nth is None else told.nth.whole
    return Condition(sign(told, dry_run), dry_run.name, nth)


def expectation(told: keys.Expect, node: Item | None, participants: Participants) -> Expectation:
    """What should be seen, or never; raises as `condition` does."""
    dry_run = participants.dry_run(node, told.place)
    within = None if told.within is None else told.within.seconds
    before = None if told.before is None else condition(told.before, node, participants)
    if told.silence is not None:
        frame = AnyFrame(by_master=told.sender is not None)
        return Expectation(frame, within, before, never=True)
    never = told.never is not None or _is_none(told.emcy) or _is_none(told.heartbeat)
    return Expectation(sign(told.never or told, dry_run), within, before, never)


def sign(told: keys.Sign, dry_run: DryRun) -> Matcher:
    """The one thing that is told.

    Raises:
        UserError: the node has no such object.
    """
    for kind, read in SIGNS.items():
        if (value := getattr(told, kind)) is not None:
            return read(value, dry_run, told.sender is not None)
    raise Noted  # as a problem of its value


def _is_none(value: object) -> bool:
    return isinstance(value, Item) and value.text == NONE


def _emcy(told: Item | keys.Emcy, *_: object) -> Matcher:
    if isinstance(told, Item):
        return EmcyLike()
    fields = (told.code, told.bits, told.detail)
    return EmcyLike(*(None if field is None else field.whole for field in fields))


def _frame(told: Item, _: DryRun, by_master: bool) -> Matcher:
    return FrameLike(told.text.strip().replace(".", "").upper(), by_master)


def _heartbeat(told: Item, *_: object) -> Matcher:
    return HeartbeatLike(HEARTBEATS.get(told.text))


def _value(told: Told, dry_run: DryRun, *_: object) -> Matcher:
    return Holds(wanted(told, dry_run.targets.find))


def _state(told: Item, *_: object) -> Matcher:
    return Entered(STATES[told.text])


def _write(told: Told, dry_run: DryRun, *_: object) -> Matcher:
    return Written(wanted(told, dry_run.targets.find_any))


def _nmt(told: Item, *_: object) -> Matcher:
    return Commanded(COMMANDS[told.text])


SIGNS: Mapping[str, Callable[..., Matcher]] = {
    "emcy": _emcy,
    "value": _value,
    "frame": _frame,
    "heartbeat": _heartbeat,
    "state": _state,
    "write": _write,
    "nmt": _nmt,
}
"""Called with what stands behind the key, the dry run of the node, and whether of the master."""
