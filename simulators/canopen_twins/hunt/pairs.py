"""Which pair of faults comes next: of single ones that were survived, one of which has struck.

A third of them come as they were, each at its moment; a third at one moment, as what has one cause
does: of two errors only the last is cleared. In a third one had found nothing to strike by itself
(an EMCY is lost where none is sent), and is there when the other brings it work: a master that
hears of errors by EMCY alone is found by that, and by nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from random import Random

from canopen_twins.hunt.contract import Disturbance, Plan
from canopen_twins.hunt.run import Result

IDLE, AT_ONCE = 1 / 3, 1 / 2
"""The share of pairs with a fault that has found nothing to strike, if any has not; that of one
moment among the others."""
TRIES = 8  # to draw a pair that was not drawn before
MOMENT = ("at", "when")


class Pairs(Iterator[Plan]):
    """At most so many, drawn by chance; it ends as well while there is nothing to draw from."""

    def __init__(self, chance: Random, most: int) -> None:
        self._chance = chance
        self._left = most
        self._struck: list[Plan] = []
        self._idle: dict[tuple[str, str], Plan] = {}
        """By node and fault, the first plan in which it has changed nothing: the simplest."""
        self._known: set[str] = set()

    def learn(self, result: Result, *, is_new: bool) -> None:
        """What has come of a plan; `is_new` if no run before it had the same frames."""
        if result.error or result.failures or len(result.plan.disturbances) != 1:
            return
        if is_new:
            self._struck.append(result.plan)
        elif "inject" in (told := result.plan.disturbances[0]):
            self._idle.setdefault((told.get("node", ""), result.plan.faults[0]), result.plan)

    def __next__(self) -> Plan:
        for _ in range(TRIES if self._left and len(self._struck) > 1 else 0):
            one, other = self._chance.sample(self._struck, 2)
            wrong = (*one.disturbances, *other.disturbances)
            if self._idle and self._chance.random() < IDLE:
                idle = self._idle[self._chance.choice([*self._idle])]
                wrong = (_moved(idle.disturbances[0], wrong[0]), wrong[0])
            elif self._chance.random() < AT_ONCE:
                wrong = (wrong[0], _moved(wrong[1], wrong[0]))
            plan = replace(one, disturbances=wrong)
            if plan.key not in self._known and len(set(plan.faults)) == len(plan.faults):
                self._known.add(plan.key)
                self._left -= 1
                return plan
        raise StopIteration


def _moved(disturbance: Disturbance, other: Disturbance) -> Disturbance:
    """It, at the moment of the other; a condition is of its node, so one of another node stays."""
    if disturbance.get("node") != other.get("node"):
        return disturbance
    moment = {key: other[key] for key in MOMENT if key in other}
    return {**moment, **{key: told for key, told in disturbance.items() if key not in MOMENT}}
