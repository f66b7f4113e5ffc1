"""campaign: a contract over a grid; what has been played is kept, and never played again."""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from canopen_twins.cli.command import FAILED, OK, Parser
from canopen_twins.cli.master import add_master
from canopen_twins.errors import UserError
from canopen_twins.files.whole import plain_file, write_whole
from canopen_twins.hunt.campaign import Campaign, axes, lost
from canopen_twins.hunt.cluster import Bundle, Cluster, check, play
from canopen_twins.hunt.contract import Plan
from canopen_twins.hunt.grid import read_grid
from canopen_twins.hunt.report import as_html
from canopen_twins.hunt.results import Results
from canopen_twins.hunt.run import Result
from canopen_twins.hunt.workers import MOST_JOBS, Map, workers
from canopen_twins.scenario.verdict import as_junit

PERIOD = 0.5  # seconds of real time from one line of progress to the next
WIDTH = 60
FILES = ("json", "html", "junit")


def add_campaign(parser: Parser) -> None:
    """campaign."""
    parser.add_argument("file", metavar="FILE", type=Path, help="a campaign file")
    add_master(parser)
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes at once (1)")
    parser.add_argument("--dask", metavar="ADDRESS", help="play on a dask cluster instead")
    text = "with --dask: what has to lie beside the contract there, such as the master's module"
    parser.add_argument("--upload", type=Path, action="append", default=[], metavar="F", help=text)
    text = "where runs are kept (FILE with .sqlite)"
    parser.add_output("--results", text)
    parser.add_output("--json", "write every run, for programs")
    parser.add_output("--html", "write a page with the picture")
    parser.add_output("--junit", "write JUnit XML, for CI")
    parser.set_defaults(command=campaign)


def campaign(options: argparse.Namespace) -> int:
    """Play what has not been played, and tell of all; 1 if any run has failed.

    Raises:
        UserError: something is wrong with the file, the contract, the master or the cluster.
    """
    if options.upload and not options.dask:
        raise UserError("--upload goes with --dask: here everything is there")
    if not 1 <= options.jobs <= MOST_JOBS:
        raise UserError(f"--jobs {options.jobs} is not in 1..{MOST_JOBS}")
    for name in filter(None, (getattr(options, name) for name in FILES)):
        plain_file(name)
    grid = read_grid(options.file, options.master or "")
    with Results(options.results or options.file.with_suffix(".sqlite")) as results:
        if results.told:
            print(f"canopen-twin: {results.told}", file=sys.stderr)
        runs = Campaign(grid, results)
        with _everybody(options, runs) as (everybody, one):
            played = runs.play(everybody, one, _progress(len(grid)))
        return _tell(runs, played, options)


@contextmanager
def _everybody(
    options: argparse.Namespace, runs: Campaign
) -> Iterator[tuple[Map, Callable[[Plan], Result] | None]]:
    """Who plays, and how one run is played there."""
    contract = runs.grid.contract
    scenario = contract.scenario(Plan())
    if scenario.master is None:
        raise UserError(f"{scenario.file}: who is tested? Say --master MODULE:FUNCTION")
    if options.dask:
        bundle = Bundle.of(contract, options.upload)
        with Cluster(options.dask, lost) as cluster:
            list(cluster(partial(check, bundle), [None]))
            yield cluster, partial(play, bundle)
    else:
        scenario.master.check()
        with workers(options.jobs, lost) as everybody:
            yield everybody, None


def _progress(total: int) -> Callable[[int], None]:
    """Tells how far it has come, in one line of a terminal."""
    if not sys.stderr.isatty():
        return lambda done: None
    due = time.monotonic() + PERIOD

    def tell(done: int) -> None:
        nonlocal due
        if time.monotonic() >= due:
            due = time.monotonic() + PERIOD
            print(f"\r{f'{done} played of {total} runs':{WIDTH}}\r", end="", file=sys.stderr)

    return tell


def _tell(runs: Campaign, played: int, options: argparse.Namespace) -> int:
    """What has failed, the figures, and the files that are wanted."""
    report, failed, summary = runs.report(), runs.failed(), runs.summary()
    for failure, plans in failed.items():
        first = f"the first with {axes(plans[0])}"
        print(f"{failure.what}: {len(plans)} of {len(runs.grid)} runs, {first}")
    print(f"{summary}; {played} of {len(runs.grid)} played now")
    if report.never:
        print(f"    never struck: {', '.join(report.never)}")
    texts: dict[str, Callable[[], str]] = {
        "json": runs.as_json,
        "html": lambda: as_html(report, summary),
        "junit": lambda: as_junit([runs.verdict()]),
    }
    for name, text in texts.items():
        if (path := getattr(options, name)) is not None:
            try:
                write_whole(path, text())
            except OSError as failure:
                raise UserError(f"{path} cannot be written: {failure.strerror}") from failure
    return FAILED if failed else OK
