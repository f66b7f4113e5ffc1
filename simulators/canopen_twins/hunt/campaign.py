"""A campaign: every run of a grid, once; what came of it is the same whoever has played it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, replace
from functools import cached_property, partial
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.grid import Grid
from canopen_twins.hunt.report import HOUR, Report, as_verdict, counted
from canopen_twins.hunt.results import Results
from canopen_twins.hunt.run import Cell, Failure, Result, run
from canopen_twins.hunt.workers import Death, Map, in_turn
from canopen_twins.scenario.verdict import Kind, Outcome, Verdict

Told = dict[str, Any]
"""What is kept of a run: plain data, without a path or a time of this machine."""
VERSION = 1  # of the JSON


class Campaign:
    """The runs of a grid, those that are kept and those that are still to be played."""

    def __init__(self, grid: Grid, results: Results) -> None:
        self.grid = grid
        self._results = results

    def play(
        self,
        everybody: Map = in_turn,
        play: Callable[[Plan], Result] | None = None,
        tell: Callable[[int], None] = lambda done: None,
    ) -> int:
        """Play what is not kept yet; how many runs that were.

        Args:
            everybody: Who plays, and how many at once.
            play: One run; by default that of the contract as it lies here.
            tell: Called with the number of runs that have been played, after each.
        """
        missing = [(plan, key) for plan, key in self._keyed if key not in self._results]
        plans = [plan for plan, _ in missing]
        playing = everybody(play or partial(run, self.grid.contract), plans)
        for done, ((_, key), result) in enumerate(zip(missing, playing, strict=True), start=1):
            self._results.keep(key, self._told(result))
            tell(done)
        return len(missing)

    def key(self, plan: Plan) -> str:
        """All that a run depends on: its text, the master's files, and this program."""
        return sha256(f"{self._code}\n{self.grid.contract.text(plan)}".encode()).hexdigest()

    @cached_property
    def _keyed(self) -> list[tuple[Plan, str]]:
        """A key is the text of a run, which is written once."""
        return [(plan, self.key(plan)) for plan in self.grid.plans()]

    @cached_property
    def _code(self) -> str:
        return "\n".join([version("canopen-twins"), *sources(self.grid.contract)])

    def _told(self, result: Result) -> Told:
        here = f"{self.grid.contract.file.parent}/"
        return {
            "failures": [asdict(failure) for failure in result.failures],
            "error": result.error.replace(here, ""),
            "trace": result.trace,
            "seconds": result.seconds,
            "cells": [list(asdict(cell).values()) for cell in result.cells],
            "fired": result.fired,
        }

    def runs(self) -> Iterator[tuple[Plan, Told]]:
        """All that are kept, in the order of the grid."""
        for plan, key in self._keyed:
            if key in self._results:
                yield plan, self._results[key]

    def failed(self) -> Mapping[Failure, list[Plan]]:
        """The runs that have failed, by what did not come; the first one first."""
        found: dict[Failure, list[Plan]] = {}
        for plan, told in self.runs():
            for failure in told["failures"]:
                found.setdefault(Failure(**failure), []).append(plan)
        return found

    def report(self) -> Report:
        """As that of a hunt: what was covered, and how it ended."""
        report = Report(self.grid.contract, seed=self.grid.seeds[0])
        for plan, told in self.runs():
            failures = tuple(Failure(**each) for each in told["failures"])
            cells = tuple(Cell(*each) for each in told["cells"])
            seconds = told["seconds"]
            report.count(Result(plan, failures, told["error"], "", seconds, cells))
        report.faults = sorted({fault for plan in self.grid.plans() for fault in plan.faults})
        return report

    def verdict(self) -> Verdict:
        """A case for everything that has failed, then for every fault."""
        survived = as_verdict(self.report())
        failed = [
            Outcome(Kind.FAIL, 0.0, 1, failure.what, f"{len(plans)} runs: {axes(plans[0])}")
            for failure, plans in self.failed().items()
        ]
        name = f"campaign with {survived.file}"
        return replace(survived, name=name, outcomes=(*failed, *survived.outcomes))

    def summary(self) -> str:
        """All of it in one line."""
        told = [told for _, told in self.runs()]
        failed = sum(bool(each["failures"]) for each in told)
        errors = [each["error"] for each in told if each["error"]]
        void = f", {len(errors)} said nothing ({errors[0]})" if errors else ""
        hours = sum(each["seconds"] for each in told) / HOUR
        runs = f"{counted(len(told), 'run')}, {failed} failed{void}"
        return f"{self.grid.contract.file}: {runs}, {hours:.2f} simulated hours"

    def as_json(self) -> str:
        """Every run with what was different in it: the same to the byte whoever has played them."""
        runs = [{**axes(plan), **_summed(told)} for plan, told in self.runs()]
        return json.dumps({"version": VERSION, "runs": runs}, indent=1)


def lost(plan: Plan, _: Death) -> Result:
    """What came of a run that ends every process, or takes for ever."""
    return Result(plan, (Failure("master: ends its process, or never waits", "", ""),))


def axes(plan: Plan) -> Told:
    """What is different in a run."""
    settings = {f"{node}.{name}".lstrip("."): value for node, name, value in plan.settings}
    return {"seed": plan.seed, "settings": settings, "disturbances": list(plan.disturbances)}


def _summed(told: Told) -> Told:
    verdict = "ERROR" if told["error"] else "FAIL" if told["failures"] else "PASS"
    return {"verdict": verdict, **{key: told[key] for key in ("failures", "error", "trace")}}


def sources(contract: Contract) -> Iterator[str]:
    """The content of the master's module and of what lies beside it, as digests."""
    scenario = contract.scenario(Plan())
    if scenario.master is None:
        return
    name = scenario.master.name.partition(":")[0].partition(".")[0]
    for folder in dict.fromkeys(scenario.master.folders):
        if (folder / f"{name}.py").is_file() or (folder / name).is_dir():
            for path in sorted(_python_files(folder, name)):
                yield f"{path.relative_to(folder)} {sha256(path.read_bytes()).hexdigest()}"
            return


def _python_files(folder: Path, package: str) -> Iterator[Path]:
    yield from folder.glob("*.py")
    yield from (folder / package).rglob("*.py")
