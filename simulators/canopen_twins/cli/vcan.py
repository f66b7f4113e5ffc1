"""vcan: a command on a real vcan0, here or in a guest."""

import argparse
from pathlib import Path

from canopen_twins.bus import vcan as guest
from canopen_twins.cli.command import Parser, seconds


def add_vcan(parser: Parser) -> None:
    """vcan."""
    parser.add_argument(
        "--limit",
        type=seconds,
        default=300.0,
        metavar="SECONDS",
        help="end it after this time (300)",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="keep what is written there; the rest is lost"
    )
    parser.add_argument("words", nargs="+", metavar="COMMAND", help="after --, with its arguments")
    parser.set_defaults(command=vcan)


def vcan(options: argparse.Namespace) -> int:
    """Run it, and end as it ends; 124 when its time is up."""
    return guest.run(options.words, options.limit, options.out)
