"""Reads the steps of a scenario, in the order of their times."""

from simulators.documents.document import Item
from simulators.documents.problems import Problems
from simulators.replay.expect import Expectation
from simulators.replay.rehearsal import Rehearsal
from simulators.replay.scenario import Action, At, Step
from simulators.replay.verbs import VERBS

BESIDE = {key: verb for verb, told in VERBS.items() for key in told.beside}


class StepReader:
    """Reads one step after the other; notes as a problem what is wrong with one and goes on.

    Without a rehearsal, as nobody knows the device, only keys and times are checked.
    """

    def __init__(self, node: str, rehearsal: Rehearsal | None) -> None:
        self.steps: list[Step] = []
        self._node = node
        self._rehearsal = rehearsal
        self._latest = 0.0

    def read(self, item: Item) -> None:
        """Take the next step."""
        with item.problems.at(item):
            fields = item.fields(("at",), ("note", *VERBS, *BESIDE))
            at = self._time(fields, item.problems)
            note = fields["note"].text if "note" in fields else ""
            action = self._action(item, fields)
            if action is not None:
                self._check_order(item, at, action)
                self.steps.append(Step(At(at), self._node, action, note, item.line))

    def _time(self, fields: dict[str, Item], problems: Problems) -> float:
        if "at" in fields:
            with problems.at(at := fields["at"]):
                if at.seconds < self._latest:
                    raise at.wrong(f"{at.text} s is before {self._latest:g} s, of a step above")
                self._latest = at.seconds
        return self._latest

    def _action(self, item: Item, fields: dict[str, Item]) -> Action | None:
        verb = item.choice("do", fields, VERBS)
        beside = {key: fields[key] for key in BESIDE if key in fields}
        for key, value in beside.items():
            if BESIDE[key] != verb:
                raise value.wrong(f"{key!r} stands beside {BESIDE[key]!r} only")
        if self._rehearsal is None:
            return None
        with fields[verb].blamed():
            return VERBS[verb].parse(fields[verb], self._rehearsal, **beside)

    def _check_order(self, item: Item, at: float, action: Action) -> None:
        """What is expected of a moment is judged when it is over, so it stands behind."""
        before = self.steps[-1] if self.steps else None
        if before is None or before.moment != At(at) or isinstance(action, Expectation):
            return
        if isinstance(before.action, Expectation):
            raise item.wrong("put it before what is expected at the same time, or give it a later")
