"""The search: single faults, soon pairs of them, too, then freely, until the budget is spent.

What is found is shrunk and written at once, and the search goes on for others.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from random import Random
from typing import Any

from canopen_twins.bench.python_master import PythonMaster
from canopen_twins.errors import UserError
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.events import Events, events_of
from canopen_twins.hunt.find import SUFFIX, Find, NotTheSameError, write_find
from canopen_twins.hunt.pairs import Pairs
from canopen_twins.hunt.report import Report, ThrownAway
from canopen_twins.hunt.run import Failure, Result, difference, ended, run, run_to_compare
from canopen_twins.hunt.shrink import (
    LEAST_SECONDS,
    MOST_DEATHS,
    MOST_IN_REAL_TIME,
    MOST_RUNS,
    MOST_SECONDS,
    Shrinker,
)
from canopen_twins.hunt.space import Space
from canopen_twins.hunt.sweep import Sweep
from canopen_twins.hunt.workers import Death, Map, in_turn
from canopen_twins.live.hub_process import hub_process
from canopen_twins.scenario import Scenario, Verdict, load

SECONDS = 60.0
"""Of a hunt of which nobody says how long it goes on."""
SHORTEST = 0.1  # seconds of a contract in which anything can go wrong
FIRST = 1000
"""Single faults, before the others come in turn with everything mixed."""
ALONE, BESIDE, PAIRS = 200, 4, 300
"""So many single faults come first, then a pair after every few of them, and so many in all."""
BATCHES, SINGLES = 4, 160
"""Of the mixed, and of singles, in turn."""


class Budget:
    """How much may be played: so many runs, or so many seconds of real time."""

    def __init__(self, runs: int | None = None, seconds: float | None = None) -> None:
        self._runs = runs
        self.until = None if seconds is None else time.time() + seconds
        """As `time.time()`; None: however long it takes."""

    @property
    def is_late(self) -> bool:
        """Whether the time for it is over."""
        return self.until is not None and time.time() >= self.until

    def left(self, runs: int) -> bool:
        """Whether there is some left after so many runs."""
        return not self.is_late and (self._runs is None or runs < self._runs)

    def some(self, most: int, runs: int) -> int:
        """How many may be played together after so many runs."""
        if not self.left(runs):
            return 0
        return most if self._runs is None else min(most, self._runs - runs)

    @property
    def to_shrink(self) -> float:
        """Seconds in which a find may become simple: some, even when all is spent."""
        if self.until is None:
            return MOST_SECONDS
        return min(MOST_SECONDS, max(LEAST_SECONDS, self.until - time.time()))


class BrokenContract(UserError):  # noqa: N818 - of the user's, not of ours
    """The contract fails without any fault, or says nothing."""


class Hunt:
    """One hunt with one contract; `tell` is called with the report after every run."""

    def __init__(  # noqa: PLR0913 - what can be chosen
        self,
        contract: Contract,
        *,
        seed: int = 1,
        budget: Budget,
        folder: Path = Path(),
        known: Iterable[Path] = (),
        play: Map = in_turn,
        tell: Callable[[Report], None] = lambda report: None,
    ) -> None:
        self.report = Report(contract, seed)
        self._contract = contract
        self._chance = Random(seed)
        self._budget = budget
        self._folder = folder
        self._known = known
        self._play = play
        self._tell = tell
        self._failures: set[Failure] = set()
        self._traces: set[str] = set()
        self._sweep = Sweep([])
        self._pairs = Pairs(self._chance, 0)
        self._on_their_way = 0

    def hunt(self) -> Report:
        """Search until the budget is spent.

        Raises:
            UserError: something is wrong with the contract or its master.
        """
        events, space = self._without_faults()
        self._try_known()
        self._try(space.at_delivery())
        self._sweep = Sweep(space.singles(), lambda result: space.learn(result.waits))
        self._pairs = Pairs(self._chance, PAIRS if space.limits.most > 1 else 0)
        self._try(self._first())
        while self._left:
            self._search_freely(events)
            self._try(islice(self._sweep, SINGLES))
        return self.report

    def _without_faults(self) -> tuple[Events, Space]:
        scenario = self._contract.scenario(Plan())
        if scenario.master is None and not self._contract.command:
            raise UserError(f"{scenario.file}: who is tested? Say --master MODULE:FUNCTION")
        (first,) = self._play(partial(first_run, self._folder), [self._contract])
        if isinstance(first, Death):
            where = f" in {first.place}" if first.place else ""
            raise BrokenContract(
                f"without any fault this master ends its process: {first.words}{where}"
            )
        events, verdict = first
        if not verdict.ok:
            raise BrokenContract(broken(verdict))
        if verdict.seconds < SHORTEST:
            raise BrokenContract(f"{scenario.file}: it is over at once: give it a 'duration'")
        if not self._contract.command:
            self._expect_the_same(scenario)
        space = Space(scenario, events)
        self.report.weather = scenario.space.weather
        self.report.faults, self.report.left_out = space.faults, space.left_out
        return events, space

    def _expect_the_same(self, scenario: Scenario) -> None:
        one, other = (self._compared(self._contract, Plan()) for _ in range(2))
        self.report.count(one)
        self._traces.add(one.trace)
        if told := difference(one, other):
            raise BrokenContract(
                f"{scenario.file}: two runs without any fault are not the same: the master depends"
                f" on something that is not in simulated time. They differ: {told}"
            )

    def _results(self, contract: Contract, plans: Iterable[Plan]) -> Iterator[Result]:
        """What comes of plans, in their order."""
        for result in self._play(partial(run, contract), plans):
            yield _alive(contract, result)

    def _compared(self, contract: Contract, plan: Plan) -> Result:
        """One run, with its frames."""
        (result,) = self._play(partial(run_to_compare, contract), [plan])
        return _alive(contract, result)

    def _one(self, plan: Plan) -> Result:
        (result,) = self._results(self._contract, [plan])
        return result

    @property
    def _left(self) -> bool:
        return self._budget.left(self.report.runs)

    def _try_known(self) -> None:
        """The finds of before; what still fails is not looked for again."""
        for path in self._known:
            contract = replace(self._contract, file=path)
            if not self._is_of_this_master(contract):
                self.report.others.append(str(path))
                continue
            (result,) = self._results(contract, [Plan()])
            self.report.count(result)
            if result.error:
                raise UserError(f"{path}: {result.error}")
            if result.verdict is None:
                self.report.mended.append(str(path))
            for failure in result.failures:
                self._failures.add(failure)
            if result.verdict is not None:
                failure, text = result.failures[0], path.read_text("utf-8")
                self.report.known.append(Find(failure, path, Plan(), result.verdict, 0, text))

    def _is_of_this_master(self, find: Contract) -> bool:
        """Whether it names none, or the one that is tested; raises `UserError` if it is damaged."""
        named = load(find.file).master
        tested = self._contract.scenario(Plan()).master
        return named is None or (tested is not None and named.name == tested.name)

    def _while_left(self, plans: Iterable[Plan]) -> Iterator[Plan]:
        """Those that are on their way will have been played, too."""
        for plan in plans:
            if not self._budget.left(self.report.runs + self._on_their_way):
                return
            self._on_their_way += 1
            yield plan

    def _try(self, plans: Iterable[Plan]) -> None:
        for result in self._results(self._contract, self._while_left(plans)):
            self._on_their_way -= 1
            self._take(result)
            if self._budget.is_late:  # nobody waits for the others
                break
        self._on_their_way = 0

    def _take(self, result: Result) -> None:
        self.report.count(result)
        self._sweep.learn(result)
        self._pairs.learn(result, is_new=result.trace not in self._traces)
        if not result.error:
            self._traces.add(result.trace)
        for failure in result.failures:
            if failure not in self._failures:
                self._failures.add(failure)
                self._pursue(result, failure)
        self._tell(self.report)

    def _pursue(self, result: Result, failure: Failure) -> None:
        """Make a file of it at once, and then a simpler one in its place."""
        try:
            find = self._written(result.plan, failure)
        except NotTheSameError as told:
            self._failures.discard(failure)
            self.report.thrown_away.append(ThrownAway(result.plan, str(told)))
            return
        finally:
            self.report.runs += 1
        self.report.finds.append(find)
        self._tell(self.report)
        most = MOST_DEATHS if result.death else MOST_RUNS
        if self._contract.command:
            most = MOST_IN_REAL_TIME
        parts, seconds = self._contract.parts, self._budget.to_shrink
        shrinker = Shrinker(failure, self._one, parts, most, seconds)
        plan = shrinker.shrink(result.plan)
        self.report.runs += shrinker.runs
        if plan != result.plan:
            with suppress(NotTheSameError):  # then the first one stays
                self.report.finds[-1] = self._written(plan, failure, find)

    def _written(self, plan: Plan, failure: Failure, before: Find | None = None) -> Find:
        """Raises `NotTheSameError` if it does not come again."""
        result = self._compared(self._contract, plan)
        if failure not in result.failures:
            told = difference(self._compared(self._contract, plan), result)
            raise NotTheSameError(f"it has not failed again{told and f'; two runs differ: {told}'}")
        place, play = self._folder, self._compared
        return write_find(self._contract, result, failure, place, play, before=before)

    def _first(self) -> Iterator[Plan]:
        """Single faults, and pairs: not behind all, where no hunt of a minute ever gets."""
        for number, plan in enumerate(islice(self._sweep, FIRST)):
            yield plan
            if number >= ALONE and number % BESIDE == 0:
                yield from islice(self._pairs, 1)
        yield from self._pairs

    def _search_freely(self, events: Events) -> None:
        # it takes half a second: for a hunt that gets this far
        from canopen_twins.hunt.free import RUNS, Batch, search, suspects  # noqa: PLC0415

        with tempfile.TemporaryDirectory() as folder:

            def batches() -> Iterator[Batch]:
                for number in range(BATCHES):
                    most = self._budget.some(RUNS, self.report.runs + self._on_their_way)
                    if not most:
                        return
                    self._on_their_way += most
                    asked.append(most)
                    cells = frozenset((*self.report.passed, *self.report.failed))
                    known = frozenset(self._failures)
                    drawn, until = self._chance.getrandbits(32), self._budget.until
                    place = Path(folder, str(number))
                    yield Batch(self._contract, events, drawn, known, cells, most, until, place)

            asked: list[int] = []
            for number, results in enumerate(self._play(search, batches())):
                self._on_their_way -= asked[number]
                for result in [] if isinstance(results, Death) else results:
                    self._take(result)
                for result in self._results(self._contract, suspects(Path(folder, str(number)))):
                    self._take(result)


def first_run(finds: Path, contract: Contract) -> tuple[Events, Verdict]:
    """Without any fault: what happens in it, and its verdict.

    Raises:
        UserError: its master cannot be run, or not from where finds are to lie.
    """
    scenario = contract.scenario(Plan())
    if scenario.master is not None:
        scenario.master.check()
        try:
            PythonMaster.beside(scenario.master.name, finds / "find").check()
        except UserError as refusal:
            raise UserError(
                f"finds in {finds} would not find their {refusal}: have a folder for them beside"
                " the contract (--finds)"
            ) from refusal
    return events_of(contract, scenario)


def lost(item: object, death: Death) -> Any:
    """What came of a plan or of anything else that ends every process, or takes for ever."""
    return Result(item, death=death) if isinstance(item, Plan) else death


def _alive(contract: Contract, result: Result) -> Result:
    """With what its end is to a hunt."""
    return result if result.death is None else ended(contract, result.plan, result.death)


def broken(verdict: Verdict) -> str:
    """Why a contract is no use: it is not kept without any fault."""
    bad = [each for each in verdict.outcomes if not _is_good(each)]
    told = [f"{verdict.file}:{each.line}: {each.kind}: {each.what}: {each.seen}" for each in bad]
    return "\n".join(["without any fault this master does not keep the contract:", *told])


def _is_good(outcome: Any) -> bool:
    return str(outcome.kind) in ("PASS", "SKIP")


def hunt(  # noqa: PLR0913 - what can be chosen
    file: Path,
    master: str = "",
    *,
    runs: int | None = None,
    seconds: float | None = None,
    seed: int = 1,
    folder: Path | None = None,
    command: Sequence[str] = (),
    play: Map = in_turn,
    tell: Callable[[Report], None] = lambda report: None,
) -> Report:
    """Hunt with the contract of a file; for a minute, if neither runs nor seconds are given.

    Args:
        file: The contract.
        master: `MODULE:FUNCTION`; empty: that of the file.
        runs: How many runs are played at most.
        seconds: How long it goes on, in real time.
        seed: Where chance begins.
        folder: Where finds are written, and those of before are played; None: here, and none.
        command: A program and its arguments in place of a master in Python, beside twins in real
            time on buses of their own.
        play: Where runs are played.
        tell: Called with the report after every run.

    Raises:
        UserError: something is wrong with one of them, the extra is missing, or the contract is not
            kept without faults.
    """
    _check(file, folder, runs, seconds)
    if runs is None and seconds is None:
        seconds = SECONDS
    known = [] if folder is None else sorted(folder.glob(f"*{SUFFIX}"))
    with hub_process() if command else nullcontext() as hub:
        contract = Contract(file, master, tuple(command), "" if hub is None else str(hub))
        return Hunt(
            contract,
            seed=seed,
            budget=Budget(runs, seconds),
            folder=folder or Path(),
            known=known,
            play=play,
            tell=tell,
        ).hunt()


def _check(file: Path, folder: Path | None, runs: int | None, seconds: float | None) -> None:
    """Raises `UserError` if there can be no such hunt."""
    if find_spec("hypothesis") is None:  # before, not when all but the free search has been done
        raise UserError("a hunt needs the extra: pip install 'canopen-twins[hunt]'")
    if not file.is_file():
        raise UserError(f"there is no file {file}")
    if folder is not None and not folder.is_dir():
        raise UserError(f"there is no directory {folder}")
    try:
        tempfile.TemporaryFile(dir=folder or Path()).close()
    except OSError as failure:
        raise UserError(
            f"finds cannot be written to {folder or Path()}: {failure.strerror}"
        ) from failure
    if (runs is not None and runs < 1) or (seconds is not None and seconds <= 0):
        raise UserError("there has to be time for at least one run: --runs 100, --seconds 60")
