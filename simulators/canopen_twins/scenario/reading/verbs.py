"""What a step can do: a verb is a function that reads what stands behind it, and an entry below."""

from collections.abc import Callable, Mapping

from canopen_twins.bus.frame import Frame
from canopen_twins.files.document import Item
from canopen_twins.files.problems import Noted
from canopen_twins.scenario.actions import Action, Clear, Expectation, Inject, Nmt, Power, Send, Set
from canopen_twins.scenario.matchers import COMMANDS, Condition
from canopen_twins.scenario.reading.participants import Participants
from canopen_twins.scenario.reading.signs import condition, expectation
from canopen_twins.scenario.reading.transfers import read, write
from canopen_twins.scenario.schema import AnyStep, Expect
from canopen_twins.scenario.words import ALL_FAULTS, SWITCHES

Values = Mapping[Item, Item]


def action(step: AnyStep, participants: Participants) -> Action:
    """What a step does.

    Raises:
        UserError: its node cannot do it, or there is no such node.
    """
    for verb, mean in VERBS.items():
        if (told := getattr(step, verb)) is not None:
            with step.place.pairs[verb].value.blamed():
                return mean(told, step, participants)
    raise Noted  # as a problem of its value


def _set(told: Values, step: AnyStep, participants: Participants) -> Action:
    return Set(participants.dry_run(step.node, step.place).set(told))


def _send(told: Item, step: AnyStep, participants: Participants) -> Action:
    return Send(Frame.parse(told.text))


def _nmt(told: Item, step: AnyStep, participants: Participants) -> Action:
    participants.dry_run(step.node, step.place)
    return Nmt(COMMANDS[told.text])


def _power(told: Item, step: AnyStep, participants: Participants) -> Action:
    participants.dry_run(step.node, step.place)
    return Power(SWITCHES[told.text])


def _inject(
    told: Item | Mapping[Item, Values], step: AnyStep, participants: Participants
) -> Action:
    dry_run = participants.dry_run(step.node, step.place)
    lasts = _lasts(step, participants)
    value = step.place.pairs["inject"].value
    faults = {}
    for name, given in ({told: {}} if isinstance(told, Item) else told).items():
        with name.problems.at(value.pairs[name.text].value if value.is_mapping else name):
            faults[name.text] = dry_run.inject(name, given)
            if lasts is not None:
                dry_run.heal(name)
    return Inject(faults, lasts)


def _lasts(step: AnyStep, participants: Participants) -> float | Condition | None:
    if step.until is not None:
        return condition(step.until, step.node, participants)
    return None if step.lasts is None else step.lasts.seconds


def _clear(told: Item, step: AnyStep, participants: Participants) -> Action:
    fault = None if told.text == ALL_FAULTS else told.text
    participants.dry_run(step.node, step.place).clear(fault)
    return Clear(fault)


def _expect(told: Expect, step: AnyStep, participants: Participants) -> Expectation:
    return expectation(told, step.node, participants)


VERBS: Mapping[str, Callable[..., Action]] = {
    "set": _set,
    "write": lambda told, step, participants: write(
        told, step, participants.dry_run(step.node, step.place)
    ),
    "read": lambda told, step, participants: read(
        told, step, participants.dry_run(step.node, step.place)
    ),
    "send": _send,
    "nmt": _nmt,
    "power": _power,
    "inject": _inject,
    "clear": _clear,
    "expect": _expect,
}
"""Called with what stands behind the key, the step and those who take part."""
