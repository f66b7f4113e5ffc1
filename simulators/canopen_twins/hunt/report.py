"""What a hunt has come to: for people, for programs, as JUnit, and as a page with a picture."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from html import escape
from typing import NamedTuple

from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.find import Find
from canopen_twins.hunt.run import Cell, Result
from canopen_twins.scenario.verdict import Kind, Outcome, Verdict

VERSION = 1  # of the JSON
HOUR = 3600.0


class ThrownAway(NamedTuple):
    """A plan that has not failed again in the same way."""

    plan: Plan
    why: str
    """With the first frame that was another one."""


@dataclass
class Report:
    """What a hunt has come to so far."""

    contract: Contract
    seed: int
    weather: str = ""
    runs: int = 0
    void: int = 0
    """Runs that said nothing about the master."""
    left_behind: int = 0
    """Runs whose master has left processes behind."""
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
    mended: list[str] = field(default_factory=list)
    """Files of finds of before that pass now."""
    others: list[str] = field(default_factory=list)
    """Those that name another master, and are not played."""
    thrown_away: list[ThrownAway] = field(default_factory=list)

    def count(self, result: Result) -> None:
        """Take a run."""
        self.runs += 1
        self.simulated += result.seconds
        self.void += bool(result.error)
        self.left_behind += result.left_behind
        if not result.error:
            (self.failed if result.failures else self.passed).update(set(result.cells))

    @property
    def ok(self) -> bool:
        """Whether nothing has been found, nor is left of before."""
        return not (self.finds or self.known)

    @property
    def phases(self) -> list[str]:
        """In which anything has gone wrong, in their order."""
        return sorted({cell.phase for cell in (*self.passed, *self.failed)})

    @property
    def never(self) -> list[str]:
        """Faults that have not struck in any run."""
        struck = {cell.fault for cell in (*self.passed, *self.failed)}
        return [fault for fault in self.faults if fault not in struck]


def lines(report: Report) -> Iterator[str]:
    """For people: what has been found, and what has been done."""
    for find in report.known:
        yield f"{find.file}: still fails: {find.outcome.what}: {find.outcome.seen}"
    for find in report.finds:
        yield f"{find.file}: {find.outcome.what}: {find.outcome.seen}"
        wrong = ", ".join(find.plan.faults) or "settings alone"
        yield f"    {wrong}: {counted(find.plan.size, 'step')} beyond the contract"
    yield from (f"{file}: passes now" for file in report.mended)
    yield summary(report)
    if report.others:
        yield f"    not played, of another master: {', '.join(report.others)}"
    for plan, why in report.thrown_away:
        yield f"    thrown away: {', '.join(plan.faults) or 'settings alone'}: {why}"
    if report.left_behind:
        runs = counted(report.left_behind, "run")
        yield f"    the master has left processes behind in {runs}: they were ended"
    if report.never:
        yield f"    never struck: {', '.join(report.never)}"
    yield from (f"    not tried: {fault}: {why}" for fault, why in report.left_out.items())


def summary(report: Report) -> str:
    """All of it in one line."""
    thrown = f", {len(report.thrown_away)} thrown away" if report.thrown_away else ""
    runs = f"{counted(report.runs, 'run')}, {report.simulated / HOUR:.2f} simulated hours"
    weather = f"{report.weather} weather, seed {report.seed}"
    finds = f"{counted(len(report.finds), 'find')}{thrown}"
    return f"{report.contract.file}: {finds} in {runs}, {weather}"


def counted(count: int, what: str) -> str:
    """With its plural."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def as_json(report: Report) -> str:
    """In one line."""
    return json.dumps(
        {
            "version": VERSION,
            "contract": str(report.contract.file),
            "master": report.contract.master,
            "seed": report.seed,
            "weather": report.weather,
            "runs": report.runs,
            "void": report.void,
            "left_behind": report.left_behind,
            "simulated": round(report.simulated, 6),
            "thrown_away": len(report.thrown_away),
            "unequal": [{"faults": plan.faults, "why": why} for plan, why in report.thrown_away],
            "finds": [_find(each) for each in report.finds],
            "known": [_find(each) for each in report.known],
            "mended": report.mended,
            "others": report.others,
            "cells": [
                {**vars(cell), "passed": report.passed[cell], "failed": report.failed[cell]}
                for cell in sorted({*report.passed, *report.failed}, key=repr)
            ],
            "never": report.never,
            "not_tried": report.left_out,
        }
    )


def _find(find: Find) -> Mapping[str, object]:
    outcome = find.outcome
    return {
        "file": str(find.file),
        "what": outcome.what,
        "seen": outcome.seen,
        "time": outcome.time,
        "place": find.failure.place,
        "faults": find.plan.faults,
        "beyond": find.plan.size,
        "steps": find.steps,
    }


def as_verdict(report: Report) -> Verdict:
    """A case for every find, and one for every fault that was survived."""
    outcomes = [_failed(find) for find in (*report.known, *report.finds)]
    for fault in report.faults:
        runs = sum(report.passed[cell] for cell in report.passed if cell.fault == fault)
        failed = sum(report.failed[cell] for cell in report.failed if cell.fault == fault)
        kind = Kind.PASS if runs and not failed else Kind.SKIP
        seen = f"survived {counted(runs, 'time')}, not {counted(failed, 'time')}"
        outcomes.append(Outcome(kind, 0.0, 1, fault, seen if runs or failed else "never struck"))
    outcomes += [Outcome(Kind.SKIP, 0.0, 1, name, why) for name, why in report.left_out.items()]
    name = f"hunt with {report.contract.file}"
    file = str(report.contract.file)
    return Verdict(file, tuple(outcomes), name, report.seed, report.simulated)


def _failed(find: Find) -> Outcome:
    told = find.outcome
    what = f"{find.file}: {told.what}"
    return Outcome(Kind.FAIL, told.time, told.line, what, told.seen, told.note, told.scene)


STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem; color: #1b1f24; background: #fff }
table { border-collapse: collapse; margin: 1rem 0 } th { font-weight: 500; text-align: left }
th, td { padding: .2rem .6rem; border: 1px solid #d0d7de } td { text-align: center }
thead th + th { writing-mode: vertical-rl; transform: rotate(180deg); padding: .6rem .2rem }
.pass { background: #cdeed3 } .fail { background: #ffc9c4 }
.wide { overflow-x: auto } .never { color: #8c959f }
pre { white-space: pre-wrap; background: #f6f8fa; padding: 1rem }
"""


def as_html(report: Report, figures: str = "") -> str:
    """A page of its own: the figures, those of a hunt if none are given, the picture fault by
    phase, and the finds."""
    parts = [
        f"<h1>{escape(str(report.contract.file))}</h1>",
        f"<p>{escape(figures or summary(report))}</p>",
        _picture(report),
        *(_section(find) for find in (*report.known, *report.finds)),
        *(f"<p>Thrown away: {escape(why)}</p>" for _, why in report.thrown_away),
        *(f"<p>Not tried: {escape(f'{name}: {why}')}</p>" for name, why in report.left_out.items()),
    ]
    return (
        "<!doctype html><html lang=en><meta charset=utf-8><title>hunt</title>"
        f"<style>{STYLE}</style><body>{''.join(parts)}</body></html>\n"
    )


def _picture(report: Report) -> str:
    """Every fault with every phase: passed, failed or never tried."""
    columns = "".join(f"<th>{escape(phase)}</th>" for phase in report.phases)
    rows = [f"<tr><th>{escape(fault)}</th>{_row(report, fault)}</tr>" for fault in report.faults]
    head = f"<thead><tr><th>fault by phase</th>{columns}</tr></thead>"
    return f"<div class=wide><table>{head}<tbody>{''.join(rows)}</tbody></table></div>"


def _row(report: Report, fault: str) -> str:
    cells = (Cell(fault, phase) for phase in report.phases)
    return "".join(_cell(report.passed[cell], report.failed[cell]) for cell in cells)


def _cell(passed: int, failed: int) -> str:
    if failed:
        return f'<td class=fail title="failed {failed} of {passed + failed}">{failed}</td>'
    if passed:
        return f'<td class=pass title="survived {passed} times">{passed}</td>'
    return '<td class=never title="never tried">&ndash;</td>'


def _section(find: Find) -> str:
    outcome = find.outcome
    return (
        f"<h2>{escape(str(find.file))}</h2>"
        f"<p>{escape(outcome.what)}: {escape(outcome.seen)}</p>"
        f"<pre>{escape(find.text)}</pre><pre>{escape(outcome.scene)}</pre>"
    )
