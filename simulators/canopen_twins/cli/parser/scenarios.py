"""The commands of scenarios and of what is kept of their runs, all in simulated time."""

from pathlib import Path

from canopen_twins.cli.parser.arguments import kept, reports, scenarios
from canopen_twins.cli.parser.command import Commands, add

PLOT = "draw the run: .png, .svg or .html (needs the extra `plot`)"


def add_scenarios(commands: Commands) -> None:
    """play, check and schema."""
    text = "play scenarios in simulated time: a trace in candump format, then the verdict"
    parser = add(commands, "play", text, "play")
    scenarios(parser)
    reports(parser)
    parser.add_argument("--plot", type=Path, metavar="FILE", help=PLOT)
    kept(parser)
    text = "say what is wrong with scenarios, without playing them"
    scenarios(add(commands, "check", text, "scenarios"))
    text = "print the JSON Schema of scenarios or of bench files, for editors"
    parser = add(commands, "schema", text, "schema")
    parser.add_argument("file", nargs="?", choices=("scenario", "bench"), default="scenario")


def add_records(commands: Commands) -> None:
    """replay and diff."""
    text = "live through a record again: its frames in candump format, 1 if they are others now"
    parser = add(commands, "replay", text, "replay")
    parser.add_argument("record", type=Path, metavar="DIR", help="of --record")
    parser.add_argument("--plot", type=Path, metavar="FILE", help=PLOT)
    text = "explain the first difference of two records or trace files, 1 if there is one"
    parser = add(commands, "diff", text, "diff")
    for name in ("a", "b"):
        parser.add_argument(name, type=Path, metavar=name.upper(), help="a record, or a trace")
