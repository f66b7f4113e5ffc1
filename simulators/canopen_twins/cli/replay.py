"""replay and diff: a recorded run lived through again, and two runs side by side."""

import argparse
import logging
import sys
from filecmp import cmp
from pathlib import Path
from tempfile import TemporaryDirectory

from canopen_twins.cli.command import FAILED, OK, PLOT, Parser
from canopen_twins.record import Recorded, Side, differences, record, reproduce
from canopen_twins.record.plot import Plot
from canopen_twins.scenario import print_frames

log = logging.getLogger(__name__)


def add_replay(parser: Parser) -> None:
    """replay."""
    parser.add_argument("record", type=Path, metavar="DIR", help="of --record")
    parser.add_argument("--plot", type=Path, metavar="FILE", help=PLOT)
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
    parser.set_defaults(command=diff)


def diff(options: argparse.Namespace) -> int:
    """Whether they are the same, or the first difference in words."""
    same, told = differences(Side.of("A", options.a), Side.of("B", options.b))
    print(told)
    return OK if same else FAILED
