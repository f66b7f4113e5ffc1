"""Hunts every mutant of the reference masters: `python -m benchmarks.mutants`.

A mutant is a reference master with one mistake; docs/explanation/mutants.md tells which of them are
found, and with how little. A hunt ends with its first find, or with its budget, which is one of
runs: these are the same on every machine, whatever else it does.
"""

import argparse
import logging
import os
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import partial
from io import StringIO
from multiprocessing import get_context
from pathlib import Path

from canopen_twins.hunt.contract import Contract
from canopen_twins.hunt.find import note_of
from canopen_twins.hunt.search import BrokenContract, Hunt
from tests.hunt.mutants import Mutant, UntilFound, mutants

PAGE = Path(__file__).parent.parent / "docs" / "explanation" / "mutants.md"
RUNS = {"topcon": 1500, "charger": 500, "gateway": 370}
GOAL, BEYOND = 0.9, 3
HEAD = """# Mutants: does a hunt find the bug?

Written by `python -m benchmarks.mutants`.

The [reference masters](../examples/masters/) keep their contracts in a hunt. Each of these mutants
is one of them with one mistake that real masters make, and nothing else; without any fault each
keeps its contract, too. They lie in `tests/hunt/mutants`. A hunt was in rough weather with seed
{seed}, and ended with its first find, or after as many runs as two idle cores play in about 60 s:
{budgets}. The seconds are those of this time, with {at_once} at a time, each in one
process, on {cores} cores that had a load of {load:.0f}; they include the time in which a find
becomes simple and is seen to fail again in another process.

**{found} of {all} are found**, {simple} with at most {beyond} things beyond the contract.

| master of | mistake | found after | runs | beyond | what has to go wrong, and what is seen |
| --- | --- | ---: | ---: | ---: | --- |
{rows}
"""


@dataclass(frozen=True)
class Outcome:
    """What came of the hunt for a mutant; `note` is of its first find, empty if there is none."""

    mutant: Mutant
    seconds: float
    runs: int
    beyond: int = 0
    note: str = ""


def hunted(mutant: Mutant, seed: int) -> Outcome:
    """Search until something is found."""
    logging.disable(logging.CRITICAL)
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        contract = Contract(mutant.put_into(Path(folder)))
        budget = UntilFound(runs=RUNS[mutant.device])
        hunt = Hunt(contract, seed=seed, budget=budget, folder=Path(folder))
        budget.report = hunt.report
        try:
            report = hunt.hunt()
        except BrokenContract as broken:
            return Outcome(mutant, time.monotonic() - begin, 1, 0, str(broken))
    took = time.monotonic() - begin
    if not report.finds:
        return Outcome(mutant, took, report.runs)
    find = report.finds[0]
    note = note_of(find.verdict, find.failure, find.plan)
    return Outcome(mutant, took, report.runs, find.plan.size, note)


def page(outcomes: Sequence[Outcome], seed: int, at_once: int) -> str:
    """The whole page."""
    found = [each for each in outcomes if each.note]
    return HEAD.format(
        budgets=", ".join(f"{runs} for a {device}" for device, runs in RUNS.items()),
        seed=seed,
        at_once=at_once,
        cores=os.cpu_count(),
        load=os.getloadavg()[1],
        found=len(found),
        all=len(outcomes),
        simple=sum(each.beyond <= BEYOND for each in found),
        beyond=BEYOND,
        rows="\n".join(map(row, outcomes)),
    )


def row(outcome: Outcome) -> str:
    """Of the table."""
    mutant, note = outcome.mutant, outcome.note.replace("|", "\\|").replace("\n", " ")
    after = f"{outcome.seconds:.0f} s" if note else "not found"
    beyond = outcome.beyond if note else ""
    told = [mutant.device, mutant.mistake, after, outcome.runs, beyond, note]
    return f"| {' | '.join(map(str, told))} |"


def main() -> None:
    """Hunt, and write the page if all of them were hunted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of every hunt (default: 1)")
    parser.add_argument("--at-once", type=int, default=1, help="hunts at a time (default: 1)")
    parser.add_argument("--only", default="", help="those with this in their name; no page then")
    options = parser.parse_args()
    wanted = [each for each in mutants() if options.only in str(each)]
    hunt = partial(hunted, seed=options.seed)
    outcomes = []
    with ProcessPoolExecutor(options.at_once, get_context("spawn")) as pool:
        for outcome in pool.map(hunt, wanted):
            outcomes.append(outcome)
            print(row(outcome), flush=True)
    if not options.only:
        PAGE.write_text(page(outcomes, options.seed, options.at_once), "utf-8")
    found = sum(bool(each.note) and each.beyond <= BEYOND for each in outcomes)
    print(f"{found} of {len(outcomes)}; the goal is {GOAL:.0%}")


if __name__ == "__main__":
    main()
