"""A failing plan as simple as it can be: fewer things, rounder numbers, only the steps that matter.

What is left fails in the same way; that is asked of a run each time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from canopen_twins.hunt.contract import Disturbance, Plan
from canopen_twins.hunt.run import Failure, Result

MOST_RUNS, MOST_IN_REAL_TIME, MOST_DEATHS = 200, 12, 8
LEAST_SECONDS, MOST_SECONDS = 20.0, 120.0
"""Of real time, when a hunt is over meanwhile and else; runs that hang take long."""
DIGITS = (1, 2, 3)  # of a time that none of the round ones can replace
ROUND = (1.0, 2.0, 5.0, 10.0, 0.5, 0.2, 0.1, 3.0, 4.0, 20.0, 0.05, 0.02, 0.01)
"""Times, the roundest first."""

Play = Callable[[Plan], Result]


class Shrinker:
    """Knows what has been played already, and how often it may play on."""

    def __init__(
        self,
        failure: Failure,
        play: Play,
        parts: int,
        most: int = MOST_RUNS,
        seconds: float = MOST_SECONDS,
    ) -> None:
        """`parts` of a contract; at `most` so many runs, in so many seconds of real time."""
        self.runs = 0
        self._failure = failure
        self._play = play
        self._parts = parts
        self._most = most
        self._end = time.monotonic() + seconds
        self._known: dict[str, bool] = {}

    def shrink(self, plan: Plan) -> Plan:
        """The simplest that is found in time."""
        self._known[plan.key] = True
        plan = self._descend(plan, _simpler)
        return self._descend(plan, lambda plan: _shorter(plan, self._parts))

    def _descend(self, plan: Plan, simpler: Callable[[Plan], Iterator[Plan]]) -> Plan:
        """As long as one of the simpler ones fails in the same way, go on from there."""
        candidates = simpler(plan)
        while (candidate := next(candidates, None)) is not None:
            if self._fails(candidate):
                plan, candidates = candidate, simpler(candidate)
        return plan

    def _fails(self, plan: Plan) -> bool:
        if plan.key not in self._known:
            if self.runs >= self._most or time.monotonic() > self._end:
                return False
            self.runs += 1
            self._known[plan.key] = self._failure in self._play(plan).failures
        elif self._known[plan.key]:
            return False  # it was on the way here
        return self._known[plan.key]


def _simpler(plan: Plan) -> Iterator[Plan]:
    """What might do as well, the greatest steps first."""
    for n in range(len(plan.disturbances)):
        yield replace(plan, disturbances=_without(plan.disturbances, n))
    for n in range(len(plan.settings)):
        yield replace(plan, settings=_without(plan.settings, n))
    if plan.order:
        yield replace(plan, order=())
    if plan.arbitration:
        yield replace(plan, arbitration="")
    if not plan.heals:
        yield replace(plan, heals=True)
    for n, each in enumerate(plan.disturbances):
        for other in _simpler_disturbances(each):
            told = (*plan.disturbances[:n], other, *plan.disturbances[n + 1 :])
            yield replace(plan, disturbances=told)


def _without(items: Sequence[Any], n: int) -> tuple[Any, ...]:
    return (*items[:n], *items[n + 1 :])


def _simpler_disturbances(told: Disturbance) -> Iterator[Disturbance]:
    if "for" in told:
        if _is_counted(told):
            yield {key: value for key, value in told.items() if key != "for"}
        yield from ({**told, "for": time} for time in _rounder(told["for"]))
    if "at" in told:
        yield from ({**told, "at": time} for time in (0.0, *_rounder(told["at"])))
    if "when" in told and "nth" in told["when"]:
        rest = {key: value for key, value in told["when"].items() if key != "nth"}
        yield {**told, "when": rest}
        yield from ({**told, "when": {**rest, "nth": nth}} for nth in range(2, told["when"]["nth"]))
    if isinstance(inject := told.get("inject"), Mapping):
        ((fault, parameters),) = inject.items()
        for fewer in _simpler_parameters(parameters):
            simpler = {**told, "inject": {fault: fewer} if fewer else fault}
            if "for" in told or _is_counted(simpler) or not _is_counted(told):
                yield simpler


def _is_counted(told: Disturbance) -> bool:
    """Whether it strikes so many times and no more: without that, it would be another weather."""
    inject = told.get("inject")
    return isinstance(inject, Mapping) and any("times" in given for given in inject.values())


def _simpler_parameters(given: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    for key, value in given.items():
        yield {other: each for other, each in given.items() if other != key}
        if isinstance(value, float):
            yield from ({**given, key: time} for time in _rounder(value))
        elif isinstance(value, int) and value > 1:
            yield {**given, key: 1}


def _rounder(time: float) -> Iterator[float]:
    """Times that are rounder than this one."""
    place = ROUND.index(time) if time in ROUND else len(ROUND)
    yield from ROUND[:place]
    yield from dict.fromkeys(
        shorter for digits in DIGITS if (shorter := round(time, digits)) != time
    )


def _shorter(plan: Plan, parts: int) -> Iterator[Plan]:
    """Without one more part of the contract, the last ones first."""
    for n in reversed(range(parts)):
        if n not in plan.left_out:
            yield replace(plan, left_out=tuple(sorted((*plan.left_out, n))))
