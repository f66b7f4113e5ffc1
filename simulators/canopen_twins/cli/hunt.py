"""hunt: a contract, a master and a budget; finds are files, and the exit code says whether any."""

import argparse
import sys
import time
from pathlib import Path
from typing import TextIO

from canopen_twins.cli.command import FAILED, INTERRUPTED, OK, Parser, seconds
from canopen_twins.cli.master import add_master
from canopen_twins.cli.results import add_reports
from canopen_twins.errors import UserError
from canopen_twins.files.whole import report_file, write_whole
from canopen_twins.hunt.report import Report, as_html, as_json, as_verdict, lines
from canopen_twins.hunt.search import SECONDS, lost
from canopen_twins.hunt.search import hunt as search
from canopen_twins.hunt.workers import workers
from canopen_twins.scenario.verdict import as_junit

PERIOD = 0.5  # seconds of real time from one line of progress to the next
WIDTH = 78


def add_hunt(parser: Parser) -> None:
    """hunt."""
    parser.epilog = (
        "With -- COMMAND in place of --master, a process of any language is tested in real time: it"
        " is started anew for every run, and told of its bus as by run."
    )
    parser.takes_command = True
    parser.add_argument("contract", metavar="CONTRACT", type=Path, help="a scenario file")
    add_master(parser)
    parser.add_argument("--runs", type=int, metavar="N", help="play so many runs")
    text = f"search so long ({SECONDS:g} if nothing is said)"
    parser.add_argument("--seconds", type=seconds, metavar="S", help=text)
    text = "processes that play at once (1)"
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help=text)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="where chance begins")
    text = "where finds are written, and those of before are played first"
    parser.add_argument("--finds", type=Path, metavar="DIR", help=text)
    text = "write a page with the finds and a picture of what was tried"
    parser.add_output("--html", text)
    add_reports(parser)
    parser.set_defaults(command=hunt)


def hunt(options: argparse.Namespace) -> int:
    """Search, and say what has been found; 1 if anything has. Ctrl-C ends it early.

    Raises:
        UserError: something is wrong with the contract, the master or the budget.
    """
    for file in (options.html, options.junit):
        if file is not None:
            report_file(file)
    if options.words and options.master:
        raise UserError("one master is tested: --master or a COMMAND, not both")
    line = Progress(sys.stderr)
    code = None
    try:
        with workers(options.jobs, lost) as play:
            report = search(
                options.contract,
                options.master or "",
                command=options.words,
                runs=options.runs,
                seconds=options.seconds,
                seed=options.seed,
                folder=options.finds,
                play=play,
                tell=line.tell,
            )
    except KeyboardInterrupt:
        if line.report is None:  # nothing has been tried yet
            raise
        report, code = line.report, INTERRUPTED
    line.close()
    _tell(report, options)
    return code or (OK if report.ok else FAILED)


def _tell(report: Report, options: argparse.Namespace) -> None:
    if options.html is not None:
        _write(options.html, as_html(report))
    if options.junit is not None:
        _write(options.junit, as_junit([as_verdict(report)]))
    print(as_json(report) if options.json else "\n".join(lines(report)))


def _write(path: Path, text: str) -> None:
    try:
        write_whole(path, text)
    except OSError as failure:
        raise UserError(f"{path} cannot be written: {failure.strerror}") from failure


class Progress:
    """How far a hunt has come, again and again in one line of a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._shown = stream.isatty()
        self._due = time.monotonic() + PERIOD
        self.report: Report | None = None
        """As it was told last."""

    def tell(self, report: Report) -> None:
        """Write it anew, if it is time to."""
        self.report = report
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
