"""Scenarios of their files: all that is wrong is told at once, before anything is on a bus."""

import re
from collections.abc import Callable, Mapping, Sequence
from math import inf
from pathlib import Path

from canopen_twins.bench.python_master import PythonMaster
from canopen_twins.bench.simulated_time.bus import NAME
from canopen_twins.device.faults import OTHER_WORDS
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.files.document import Item, Reported
from canopen_twins.files.table import understand_table
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
from canopen_twins.scenario.matchers import (
    AnyFrame,
    Commanded,
    Condition,
    EmcyLike,
    Entered,
    FrameLike,
    HeartbeatLike,
    Holds,
    IsIn,
    Matcher,
    Written,
)
from canopen_twins.scenario.rehearsal import Find, Participants, Rehearsal
from canopen_twins.scenario.scenario import (
    After,
    At,
    EndsWith,
    Moment,
    NodeSpec,
    Recovery,
    Scenario,
    Space,
    Step,
    Whenever,
)
from canopen_twins.scenario.schema import ANY, NONE
from canopen_twins.scenario.sdo_client import ACCEPTED
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import Anything, Range, Text, Wanted, encode

Values = Mapping[Item, Item | schema.Wanted]

DEFAULT_SEED = 1
ARBITRATION = {"identifier": "", "master": NAME.format(1)}
DECIMAL_CODE = re.compile(r"[1-9][0-9]{3}")
"""An error code as manuals print it, but without 0x."""
ALL_FAULTS = "all"


def read_scenario(path: Path, find: Find, text: str | None = None) -> Scenario:
    """The scenario of a file, or of what would stand in it.

    Raises:
        DocumentError: with a line for everything that is wrong.
    """
    return understand_table(
        path, schema.ScenarioFile, lambda file: _scenario(file, path, find), text
    )


def read_bench(path: Path, find: Find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there; raises as `read_scenario` does."""
    return understand_table(
        path,
        schema.BenchFile,
        lambda file: _take(file.nodes, Participants(find, path.parent, timing=file.timing)).specs,
    )


def _scenario(file: schema.ScenarioFile, path: Path, find: Find) -> Scenario:
    participants = Participants(find, path.parent, file.seed, file.timing)
    if file.node is not None:
        name = Path(file.node.device.text).name  # of a file, too, wherever it lies
        participants.take(name, file.node, file.node.place)
    _take(file.nodes or {}, participants)
    lasts = inf if file.ends_with is EndsWith.COMMAND else file.duration
    return Scenario(
        path,
        name=file.name or path.stem,
        note=file.note,
        nodes=participants.specs,
        steps=_steps(file.steps or [], participants, lasts),
        disturbances=_disturbances(file.disturbances or [], participants),
        always=_always(file.always or [], participants),
        recovers=_recovers(file, participants),
        space=_space(file, participants),
        cleanup=_steps(file.cleanup or [], participants, 0.0),
        covers=tuple(file.covers or ()),
        seed=DEFAULT_SEED if file.seed is None else file.seed,
        duration=file.duration,
        ends_with=file.ends_with,
        stalls=file.stalls,
        bit_rate=file.bit_rate,
        bit_rate_line=0 if file.bit_rate is None else file.item_of("bit_rate").line,
        arbitration=_arbitration(file, participants),
        arbitration_line=0 if file.arbitration is None else file.arbitration.line,
        master=_master(file, path),
        master_line=1 if file.master is None else file.item_of("master").line,
    )


def _arbitration(file: schema.ScenarioFile, participants: Participants) -> str | None:
    if file.arbitration is None:
        return None
    item = file.arbitration
    known = {**{name: name for name in participants.specs}, **ARBITRATION}
    with item.problems.at(item):
        return known[item.one_of("way of arbitration", known)]
    return None


def _master(file: schema.ScenarioFile, path: Path) -> PythonMaster | None:
    if file.master is None:
        return None
    item = file.item_of("master")
    with item.problems.at(item):
        return PythonMaster.beside(file.master, path)
    return None


def _take(nodes: Mapping[Item, schema.Node | None], participants: Participants) -> Participants:
    for name, node in nodes.items():
        participants.take(name.text, node, name)
    return participants


def _steps(
    given: Sequence[schema.AnyStep | None], participants: Participants, duration: float | None
) -> tuple[Step, ...]:
    compiler = Compiler(participants)
    right = [step for step in given if step is not None]
    for step in right:
        compiler.add(step)
    if right and right[0].place.problems.none:
        _check_length([step.place for step in right], compiler.steps, duration)
    return tuple(compiler.steps)


def _disturbances(
    given: Sequence[schema.Disturbance | None], participants: Participants
) -> tuple[Step, ...]:
    found = []
    for each in (each for each in given if each is not None):
        place = each.place
        with place.problems.at(place):
            action = _action(each, participants)
            node = participants.rehearsal(each.node, place).name
            if each.when is not None:
                moment: Moment = _condition(each.when, each.node, participants)
            elif each.at is not None:
                moment = At(each.at)
            else:
                raise Reported
            found.append(Step(moment, node, action, each.note, place.line))
    return tuple(found)


def _always(
    given: Sequence[schema.Whenever | None], participants: Participants
) -> tuple[Whenever, ...]:
    found = []
    for each in (each for each in given if each is not None):
        place = each.place
        with place.problems.at(place):
            node = participants.rehearsal(each.node, place).name
            condition = _condition(each.whenever, each.node, participants)
            action = _expect(each.expect, each, participants)
            step = Step(condition, node, action, each.note, place.line)
            found.append(Whenever(condition, each.after, step))
    return tuple(found)


def _recovers(file: schema.ScenarioFile, participants: Participants) -> Recovery | None:
    if (said := file.recovers) is None:
        return None
    with said.place.problems.at(said.place):
        condition = _condition(said.when, None, participants)
        return Recovery(condition, said.within, said.place.line)
    return None


def _space(file: schema.ScenarioFile, participants: Participants) -> Space:
    if (said := file.space) is None:
        return Space(file.weather)
    for name in [*(said.faults or ()), *(said.without or ())]:
        with name.problems.at(name):
            name.one_of("fault", participants.faults, OTHER_WORDS)
    for name in said.settings or ():
        with name.problems.at(name):
            if not participants.knows(name.text):
                name.one_of("setting", participants.settings)
    return Space(
        file.weather,
        None if said.faults is None else tuple(name.text for name in said.faults),
        tuple(name.text for name in said.without or ()),
        said.most,
        {
            name.text: tuple(value.value for value in values)
            for name, values in (said.settings or {}).items()
        },
    )


class Compiler:
    """Takes the steps in the order of the file; what is wrong with one becomes a problem."""

    def __init__(self, participants: Participants) -> None:
        self.steps: list[Step] = []
        self._participants = participants
        self._latest = 0.0

    def add(self, step: schema.AnyStep) -> None:
        """Take the next step."""
        place, problems = step.place, step.place.problems
        action: Action | None = None
        moment: Moment | None = None
        with problems.at(place):
            action = _action(step, self._participants)
        with problems.at(place):
            moment = self._moment(step)
        if action is None or moment is None:
            return
        with problems.at(place):
            self._check_order(place, moment, action)
            to_anybody = step.send is not None and step.node is None
            node = "" if to_anybody else _node(step, self._participants).name
            self.steps.append(
                Step(moment, node, action, step.note, place.line, step.every, step.times)
            )

    def _moment(self, step: schema.AnyStep) -> Moment:
        if step.after is not None:
            return After(step.after)
        if not isinstance(step, schema.Step):
            return After(0)
        if step.at is not None:
            self._check_time(step.at, step.item_of("at"))
            return At(step.at)
        if step.when is not None:
            return _condition(step.when, step.node, self._participants)
        raise Reported

    def _check_time(self, seconds: float, at: Item) -> None:
        if seconds < self._latest:
            raise at.wrong(f"{at.text} s is before {self._latest:g} s, of a step above")
        self._latest = seconds

    def _check_order(self, place: Item, moment: Moment, action: Action) -> None:
        """What is expected of a moment is judged when it is over, so it stands behind."""
        before = self.steps[-1] if self.steps else None
        if before is None or isinstance(action, Expectation):
            return
        together = moment == After(0) or (isinstance(moment, At) and moment == before.moment)
        if together and isinstance(before.action, Expectation):
            raise place.wrong("put it before what is expected at the same time, or give it a later")


# What a step does: a verb is an entry, called with what is behind it, the step, and who takes part


def _action(step: schema.Change, participants: Participants) -> Action:
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
        lasts = _condition(step.until, step.node, participants)
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


def _expect(
    said: schema.Expect, step: schema.AnyStep | schema.Whenever, participants: Participants
) -> Action:
    node = participants.rehearsal(step.node, said.place)
    before = None if said.before is None else _condition(said.before, step.node, participants)
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
    "expect": _expect,
}


# What is waited for or expected


def _condition(said: schema.Seen, node: Item | None, participants: Participants) -> Condition:
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


# Whether a run is long enough for what must never come in it

IN_VAIN = (
    "the run may be over as soon as this begins, so that nothing is watched: "
    "give it 'within', or the file a 'duration'"
)


def _check_length(places: Sequence[Item], steps: Sequence[Step], duration: float | None) -> None:
    """What would watch to the end of a run that is over then becomes a problem.

    A step that waits for a condition comes at its earliest, so that some of it is not found.
    """
    begins = _begins(steps)
    length = max([duration or 0.0, *map(_end, steps, begins)])
    for number, (place, step, begin) in enumerate(zip(places, steps, begins, strict=True)):
        in_vain = _is_open(step) and length <= begin
        if in_vain and (duration is not None or not _is_waited_for(steps, number)):
            place.problems.add(UserError(IN_VAIN), place.mark)


def _begins(steps: Sequence[Step]) -> list[float]:
    """Seconds at which each step begins, or before which it does not."""
    begins: list[float] = []
    begin = end = 0.0
    for step in steps:
        if isinstance(step.moment, At):
            begin = step.moment.seconds
        elif isinstance(step.moment, After):
            begin = end + step.moment.seconds
        end = begin + (step.times - 1) * step.every
        begins.append(begin)
    return begins


def _end(step: Step, begin: float) -> float:
    """Seconds up to which it keeps the run going."""
    action, lasts = step.action, 0.0
    if isinstance(action, Expectation):
        lasts = action.seconds or 0.0
    elif isinstance(action, Inject) and isinstance(action.lasts, float):
        lasts = action.lasts
    return begin + (step.times - 1) * step.every + lasts


def _is_open(step: Step) -> bool:
    """Whether only the end of the run ends it."""
    action = step.action
    return isinstance(action, Expectation) and action.seconds is None and action.before is None


def _is_waited_for(steps: Sequence[Step], number: int) -> bool:
    """Whether others wait for a condition while one watches."""
    ends = (step.action.before for step in steps if isinstance(step.action, Expectation))
    below = (step.moment for step in steps[number + 1 :])
    return any(isinstance(each, Condition) for each in (*ends, *below))
