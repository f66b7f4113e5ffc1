"""Trace files as commands take them: which channel, which columns, and what was damaged."""

from __future__ import annotations

import argparse
import logging
from pathlib import Path

from canopen_twins.cli.command import Parser
from canopen_twins.record.trace_formats import columns
from canopen_twins.record.trace_reader import Trace

log = logging.getLogger(__name__)

COLUMNS = (
    "of a .csv: time=NAME,id=NAME,data=NAME, or numbers from 1 on, data=D1-D8 for several;"
    " ms= and us= are times, too, and there are length, extended, remote and channel"
)


def add_trace_options(parser: Parser) -> None:
    """How a trace file is read."""
    parser.add_argument("--channel", metavar="NAME", help="of a trace that has several")
    parser.add_argument("--columns", metavar="KEY=NAME,...", help=COLUMNS)


def opened(options: argparse.Namespace, path: Path) -> Trace:
    """A trace file by its path.

    Raises:
        UserError: it is none, or not there, or the options are of no use for it.
    """
    named = columns(options.columns) if options.columns else None
    return Trace(path, options.channel, named)


def tell_damage(trace: Trace) -> None:
    """Which lines were left out, on stderr."""
    for remark in trace.remarks:
        log.warning("%s", remark)
