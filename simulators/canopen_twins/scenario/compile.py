"""Scenarios of their files: all that is wrong is told at once, before anything is on a bus."""

from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path

from canopen_twins.bench.python_master import PythonMaster
from canopen_twins.bench.simulated_time.bus import NAME
from canopen_twins.device.faults import OTHER_WORDS
from canopen_twins.files.document import Item, Reported
from canopen_twins.files.table import understand_table
from canopen_twins.scenario import schema
from canopen_twins.scenario.actions import Action, Expectation
from canopen_twins.scenario.length import check_length
from canopen_twins.scenario.rehearsal import Find, Participants
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
from canopen_twins.scenario.verbs import action_of, condition_of, expectation_of

DEFAULT_SEED = 1
ARBITRATION = {"identifier": "", "master": NAME.format(1)}


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
        check_length([step.place for step in right], compiler.steps, duration)
    return tuple(compiler.steps)


def _disturbances(
    given: Sequence[schema.Disturbance | None], participants: Participants
) -> tuple[Step, ...]:
    found = []
    for each in (each for each in given if each is not None):
        place = each.place
        with place.problems.at(place):
            action = action_of(each, participants)
            node = participants.rehearsal(each.node, place).name
            if each.when is not None:
                moment: Moment = condition_of(each.when, each.node, participants)
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
            condition = condition_of(each.whenever, each.node, participants)
            action = expectation_of(each.expect, each, participants)
            step = Step(condition, node, action, each.note, place.line)
            found.append(Whenever(condition, each.after, step))
    return tuple(found)


def _recovers(file: schema.ScenarioFile, participants: Participants) -> Recovery | None:
    if (said := file.recovers) is None:
        return None
    with said.place.problems.at(said.place):
        condition = condition_of(said.when, None, participants)
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
            action = action_of(step, self._participants)
        with problems.at(place):
            moment = self._moment(step)
        if action is None or moment is None:
            return
        with problems.at(place):
            self._check_order(place, moment, action)
            to_anybody = step.send is not None and step.node is None
            node = "" if to_anybody else self._participants.rehearsal(step.node, place).name
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
            return condition_of(step.when, step.node, self._participants)
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
