"""The search: every single fault first, then pairs, then freely, until the budget is spent.

What is found is shrunk and written at once, and the search goes on for others.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from pathlib import Path
from random import Random
from typing import Any, Protocol, TypeVar

from canopen_twins.errors import UserError
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.events import Events, events_of
from canopen_twins.hunt.find import Find, write_find
from canopen_twins.hunt.run import Cell, Failure, Result, run
from canopen_twins.hunt.shrink import Shrinker
from canopen_twins.hunt.space import Space
from canopen_twins.scenario import Verdict

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")

PAIRS = 300
"""Pairs of singles, before everything is mixed."""


class Map(Protocol):
    """Calls a function with one item after the other, here or in other processes, in any order."""

    def __call__(
        self, function: Callable[[Item], Outcome], items: Iterable[Item]
    ) -> Iterator[Outcome]:
        """What comes of it; items are asked for as they are wanted."""


def in_turn(function: Callable[[Item], Outcome], items: Iterable[Item]) -> Iterator[Outcome]:
    """A `Map` in this process."""
    return map(function, items)


class Budget:
    """How much may be played: so many runs, or so many seconds of real time."""

    def __init__(self, runs: int | None = None, seconds: float | None = None) -> None:
        self._runs = runs
        self._end = None if seconds is None else time.monotonic() + seconds

    def left(self, runs: int) -> bool:
        """Whether there is some left after so many runs."""
        if self._end is not None and time.monotonic() >= self._end:
            return False
        return self._runs is None or runs < self._runs


class BrokenContract(UserError):  # noqa: N818 - of the user's, not of ours
    """The contract fails without any fault, or says nothing."""


@dataclass
class Report:
    """What a hunt has come to so far."""

    contract: Contract
    seed: int
    weather: str = ""
    runs: int = 0
    void: int = 0
    """Runs that said nothing about the master."""
    simulated: float = 0.0
    """Seconds."""
    passed: Counter[Cell] = field(default_factory=Counter)
    failed: Counter[Cell] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    """All that are tried."""
    left_out: dict[str, str] = field(default_factory=dict)
    """Faults that are not, and why."""
    finds: list[Find] = field(default_factory=list)
    known: list[Find] = field(default_factory=list)
    """Finds of before that still fail."""
    thrown_away: list[Plan] = field(default_factory=list)
    """Plans that have not failed again in the same way."""

    def count(self, result: Result) -> None:
        """Take a run."""
        self.runs += 1
        self.simulated += result.seconds
        self.void += bool(result.error)
        if not result.error:
            (self.failed if result.failures else self.passed).update(set(result.cells))


class Hunt:
    """One hunt with one contract.

    `tell` is called with the report after every run, `found` with every find.
    """

    def __init__(  # noqa: PLR0913 - what can be chosen
        self,
        contract: Contract,
        *,
        seed: int = 1,
        budget: Budget,
        folder: Path = Path(),
        play: Map = in_turn,
        tell: Callable[[Report], None] = lambda report: None,
    ) -> None:
        self.report = Report(contract, seed)
        self._contract = contract
        self._chance = Random(seed)
        self._budget = budget
        self._folder = folder
        self._play = play
        self._tell = tell
        self._failures: set[Failure] = set()
        self._interesting: list[Plan] = []
        self._traces: set[str] = set()

    def hunt(self) -> Report:
        """Search until the budget is spent.

        Raises:
            UserError: something is wrong with the contract or its master.
        """
        events, space = self._without_faults()
        self._try(space.singles())
        if space.limits.most > 1:
            self._try(islice(self._pairs(), PAIRS))
        if self._left:
            self._search_freely(events)
        return self.report

    def _without_faults(self) -> tuple[Events, Space]:
        scenario = self._contract.scenario(Plan())
        if scenario.master is None:
            raise UserError(f"{scenario.file}: who is tested? Say --master MODULE:FUNCTION")
        scenario.master.check()
        events, verdict = events_of(scenario)
        if not verdict.ok:
            raise BrokenContract(broken(verdict))
        again = run(self._contract, Plan())
        self.report.count(again)
        self._traces.add(again.trace)
        if run(self._contract, Plan()).trace != again.trace:
            raise BrokenContract(
                f"{scenario.file}: two runs without any fault are not the same: the master depends"
                " on something that is not in simulated time"
            )
        space = Space(scenario, events)
        self.report.weather = scenario.space.weather
        self.report.faults, self.report.left_out = space.faults, space.left_out
        return events, space

    @property
    def _left(self) -> bool:
        return self._budget.left(self.report.runs)

    def _while_left(self, plans: Iterable[Plan]) -> Iterator[Plan]:
        for plan in plans:
            if not self._left:
                return
            yield plan

    def _try(self, plans: Iterable[Plan]) -> None:
        for result in self._play(partial(run, self._contract), self._while_left(plans)):
            self._take(result)

    def _take(self, result: Result) -> None:
        self.report.count(result)
        if not result.error and result.trace not in self._traces:
            self._traces.add(result.trace)
            if not result.failures:
                self._interesting.append(result.plan)
        for failure in result.failures:
            if failure not in self._failures:
                self._failures.add(failure)
                self._pursue(result, failure)
        self._tell(self.report)

    def _pursue(self, result: Result, failure: Failure) -> None:
        """Make a file of it, as simple as it can be."""
        play = partial(run, self._contract)
        shrinker = Shrinker(failure, play, self._contract.steps)
        plan = shrinker.shrink(result.plan)
        result = play(plan)
        self.report.runs += shrinker.runs + 1
        written = None
        if failure in result.failures:
            written = write_find(self._contract, result, failure, self._folder)
        if written is None or result.verdict is None:
            self._failures.discard(failure)
            self.report.thrown_away.append(plan)
            return
        steps = self._contract.steps - len(plan.left_out)
        self.report.finds.append(Find(failure, written, plan, result.verdict, steps))

    def _pairs(self) -> Iterator[Plan]:
        """Of singles that have changed something and were survived."""
        singles = [plan for plan in self._interesting if plan.disturbances]
        seen = set()
        for _ in range(4 * PAIRS if len(singles) > 1 else 0):
            one, other = self._chance.sample(singles, 2)
            plan = replace(one, disturbances=(*one.disturbances, *other.disturbances))
            if plan.key not in seen and len(set(plan.faults)) == len(plan.faults):
                seen.add(plan.key)
                yield plan

    def _search_freely(self, events: Events) -> None:
        # only a hunt that gets this far needs it
        from canopen_twins.hunt.free import Batch, search  # noqa: PLC0415

        def batches() -> Iterator[Batch]:
            while self._left:
                cells = frozenset((*self.report.passed, *self.report.failed))
                known = frozenset(self._failures)
                yield Batch(self._contract, events, self._chance.getrandbits(32), known, cells)

        for results in self._play(search, batches()):
            for result in results:
                self._take(result)


def broken(verdict: Verdict) -> str:
    """Why a contract is no use: it is not kept without any fault."""
    bad = [each for each in verdict.outcomes if not _is_good(each)]
    told = [f"{verdict.file}:{each.line}: {each.kind}: {each.what}: {each.seen}" for each in bad]
    return "\n".join(["without any fault this master does not keep the contract:", *told])


def _is_good(outcome: Any) -> bool:
    return str(outcome.kind) in ("PASS", "SKIP")
