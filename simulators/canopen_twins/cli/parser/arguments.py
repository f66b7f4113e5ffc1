"""Arguments that several commands have."""

from functools import partial
from pathlib import Path

from canopen_twins.cli.parser.command import Parser

DEVICE = "one of `canopen-twin list`"
SCENARIO = "a file, or the name of one that is shipped"


def device(parser: Parser, text: str = DEVICE, nargs: str | None = None) -> None:
    """A device, and how it is delivered."""
    parser.add_argument("device", metavar="DEVICE", nargs=nargs, help=text)
    parser.add_argument(
        "-n", "--node-id", type=partial(int, base=0), metavar="ID", help="1..127, or as 0x05"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="see `settings DEVICE`"
    )
    parser.add_argument("--config", metavar="FILE", help="short for --set config=FILE")


def scenarios(parser: Parser) -> None:
    """At least one scenario."""
    parser.add_argument("scenarios", nargs="+", metavar="SCENARIO", help=SCENARIO)


def reports(parser: Parser) -> None:
    """Verdicts for programs."""
    parser.add_argument(
        "--junit", type=Path, metavar="FILE", help="write the verdict as JUnit XML, for CI"
    )
    parser.add_argument("--json", action="store_true", help="the verdict for programs")


def kept(parser: Parser) -> None:
    """What is kept of a run."""
    parser.add_argument(
        "--trace", type=Path, metavar="FILE", help="write the frames to .log, .asc, .blf or .trc"
    )
    parser.add_argument(
        "--record", type=Path, metavar="DIR", help="make a record for `replay` and `diff`"
    )
