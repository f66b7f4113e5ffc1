"""replay and diff: a recorded run lived through again, and two runs side by side."""

import argparse
import logging
import sys
from filecmp import cmp
from pathlib import Path
from tempfile import TemporaryDirectory

from canopen_twins.cli.command import FAILED, OK, PLOT, Parser
from canopen_twins.cli.traces import add_trace_options, opened, tell_damage
from canopen_twins.record.compare.tolerance_file import time_of
from canopen_twins.record.differences import MASTERS, SLAVES, Likeness, Side, differences
from canopen_twins.record.folder import Recorded, record, reproduce
from canopen_twins.record.plot import Plot
from canopen_twins.record.trace_reader import Trace
from canopen_twins.scenario import print_frames

log = logging.getLogger(__name__)


def add_replay(parser: Parser) -> None:
    """replay."""
    parser.add_argument("record", type=Path, metavar="DIR", help="of --record")
    parser.add_output("--plot", PLOT)
    parser.set_defaults(command=replay)


def replay(options: argparse.Namespace) -> int:
    """The frames to stdout, and in a line to stderr whether they are those of the record."""
    plot = Plot(options.plot) if options.plot else None
    recorded = Recorded(options.record)
    if others := recorded.other_versions:
        log.warning("%s was made with %s", options.record, others)
    with TemporaryDirectory() as folder:
        anew = Path(folder) / "replay"
        scenario = recorded.scenario.read_bytes() if recorded.manifest.scenario else None
        with record(anew, recorded.manifest, scenario, recorded.device_files) as observer:
            watched = [plot.begin] if plot else []
            reproduce(recorded, [observer, print_frames(sys.stdout), *watched])
        same, told = differences(Side.of("record", options.record), Side.of("replay", anew))
        if same and not cmp(recorded.trace, Recorded(anew).trace, shallow=False):
            same, told = False, f"{told}, but {recorded.trace} has been written otherwise"
    print(told, file=sys.stderr)
    if plot is not None:
        plot.save()
    return OK if same else FAILED


def add_diff(parser: Parser) -> None:
    """diff."""
    for name in ("a", "b"):
        parser.add_argument(name, type=Path, metavar=name.upper(), help="a record, or a trace")
    parser.add_argument("--time", metavar="TIME", help="a time may be off by, such as 5ms")
    text = "one direction, by the predefined connection set"
    parser.add_argument("--only", choices=(SLAVES, MASTERS), default="", help=text)
    add_trace_options(parser)
    parser.set_defaults(command=diff)


def diff(options: argparse.Namespace) -> int:
    """Whether they are the same, or the first difference in words."""
    time = time_of(options.time) if options.time is not None else 0
    traces: list[Trace] = []

    def open_trace(path: Path) -> Trace:
        traces.append(opened(options, path))
        return traces[-1]

    sides = Side.of("A", options.a, open_trace), Side.of("B", options.b, open_trace)
    same, told = differences(*sides, Likeness(time, options.only))
    print(told)
    for trace in traces:
        tell_damage(trace)
    return OK if same else FAILED
