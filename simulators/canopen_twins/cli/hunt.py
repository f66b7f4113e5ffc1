"""hunt: a contract, a master and a budget; finds are files, and the exit code says whether any."""

import argparse
import contextlib
import io
import logging
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from canopen_twins.cli.command import FAILED, OK, Parser
from canopen_twins.cli.master import add_master
from canopen_twins.errors import UserError
from canopen_twins.hunt.contract import Contract
from canopen_twins.hunt.search import Budget, Hunt, Report

SECONDS = 60.0
PERIOD = 0.5  # seconds of real time from one line of progress to the next
WIDTH = 78


def add_hunt(parser: Parser) -> None:
    """hunt."""
    parser.add_argument("contract", metavar="CONTRACT", type=Path, help="a scenario file")
    add_master(parser)
    parser.add_argument("--runs", type=int, metavar="N", help="play so many runs")
    text = f"search so long ({SECONDS:g} if nothing is said)"
    parser.add_argument("--seconds", type=float, metavar="S", help=text)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="where chance begins")
    parser.add_argument(
        "--finds", type=Path, default=Path(), metavar="DIR", help="where finds are written"
    )
    parser.set_defaults(command=hunt)


def hunt(options: argparse.Namespace) -> int:
    """Search, and say what has been found; 1 if anything has.

    Raises:
        UserError: something is wrong with the contract, the master or the budget.
    """
    if not options.contract.is_file():
        raise UserError(f"there is no file {options.contract}")
    if not options.finds.is_dir():
        raise UserError(f"there is no directory {options.finds}")
    seconds = options.seconds
    if seconds is None and options.runs is None:
        seconds = SECONDS
    line = Progress(sys.stderr)
    with quiet():
        search = Hunt(
            Contract(options.contract, options.master or ""),
            seed=options.seed,
            budget=Budget(options.runs, seconds),
            folder=options.finds,
            tell=line.tell,
        )
        report = search.hunt()
    line.close()
    for text in told(report):
        print(text)
    return FAILED if report.finds else OK


def told(report: Report) -> Iterator[str]:
    """For people: what has been found, and what has been done."""
    for find in report.finds:
        yield f"{find.file}: {find.outcome.what}: {find.outcome.seen}"
        wrong = ", ".join(find.plan.faults) or "settings alone"
        yield f"    {wrong}: {find.plan.size} beyond the contract"
    hours = report.simulated / 3600
    finds = f"{len(report.finds)} find{'' if len(report.finds) == 1 else 's'}"
    thrown = f", {len(report.thrown_away)} thrown away" if report.thrown_away else ""
    runs = f"{report.runs} runs, {hours:.2f} simulated hours"
    weather = f"{report.weather} weather, seed {report.seed}"
    yield f"{report.contract.file}: {finds}{thrown} in {runs}, {weather}"


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """What a master prints and logs, thousands of times, is for nobody."""
    logging.disable(logging.CRITICAL)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        logging.disable(logging.NOTSET)


class Progress:
    """How far a hunt has come, again and again in one line of a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._shown = stream.isatty()
        self._due = time.monotonic() + PERIOD

    def tell(self, report: Report) -> None:
        """Write it anew, if it is time to."""
        if self._shown and time.monotonic() >= self._due:
            self._due = time.monotonic() + PERIOD
            cells = len({*report.passed, *report.failed})
            self._write(f"{report.runs} runs, {len(report.finds)} finds, {cells} cells")

    def close(self) -> None:
        """Leave nothing of it."""
        if self._shown:
            self._write("")

    def _write(self, text: str) -> None:
        self._stream.write(f"\r{text:{WIDTH}}\r")
        self._stream.flush()
