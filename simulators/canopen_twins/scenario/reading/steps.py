"""The steps of a scenario, one after the other: when, which node, and what is done."""

from canopen_twins.files.document import Item
from canopen_twins.files.problems import Noted
from canopen_twins.scenario.actions import Action, Expectation
from canopen_twins.scenario.reading.participants import Participants
from canopen_twins.scenario.reading.signs import condition
from canopen_twins.scenario.reading.verbs import action
from canopen_twins.scenario.scenario import After, At, Moment, Step
from canopen_twins.scenario.schema import AnyStep
from canopen_twins.scenario.schema import Step as Told


class StepReader:
    """Reads one step after the other; notes as a problem what is wrong with one and goes on."""

    def __init__(self, participants: Participants) -> None:
        self.steps: list[Step] = []
        self._participants = participants
        self._latest = 0.0

    def read(self, told: AnyStep) -> None:
        """Take the next step."""
        problems, place = told.place.problems, told.place
        does: Action | None = None
        moment: Moment | None = None
        with problems.at(place):
            does = action(told, self._participants)
        with problems.at(place):
            moment = self._moment(told)
        if does is None or moment is None:
            return
        with problems.at(place):
            self._check_order(place, moment, does)
            self.steps.append(_step(told, moment, does, self._name(told)))

    def _moment(self, told: AnyStep) -> Moment:
        if told.after is not None:
            return After(told.after.seconds)
        if not isinstance(told, Told):
            return After(0)
        if told.at is not None:
            return At(self._at(told.at))
        if told.when is not None:
            return condition(told.when, told.node, self._participants)
        raise Noted  # as a problem of its value

    def _at(self, at: Item) -> float:
        if at.seconds < self._latest:
            raise at.wrong(f"{at.text} s is before {self._latest:g} s, of a step above")
        self._latest = at.seconds
        return at.seconds

    def _name(self, told: AnyStep) -> str:
        """What is sent is sent to no node in particular."""
        if told.send is not None and told.node is None:
            return ""
        return self._participants.dry_run(told.node, told.place).name

    def _check_order(self, place: Item, moment: Moment, does: Action) -> None:
        """What is expected of a moment is judged when it is over, so it stands behind."""
        before = self.steps[-1] if self.steps else None
        if before is None or isinstance(does, Expectation):
            return
        together = moment == After(0) or (isinstance(moment, At) and moment == before.moment)
        if together and isinstance(before.action, Expectation):
            raise place.wrong("put it before what is expected at the same time, or give it a later")


def _step(told: AnyStep, moment: Moment, does: Action, node: str) -> Step:
    return Step(
        moment,
        node,
        does,
        note="" if told.note is None else told.note.text,
        line=told.place.line,
        every=0.0 if told.every is None else told.every.seconds,
        times=1 if told.times is None else told.times.whole,
    )
