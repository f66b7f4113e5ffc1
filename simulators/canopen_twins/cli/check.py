"""check and schema: what scenarios may say, and what is wrong with those there are."""

import argparse
import json
import sys
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

from canopen_twins import scenario as rules
from canopen_twins.cli.command import OK, SCENARIO, WRONG_INPUT, Parser
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.shipped import scenario_file, scenarios


def add_check(parser: Parser) -> None:
    """check."""
    parser.add_argument("scenarios", nargs="+", metavar="SCENARIO", help=SCENARIO)
    parser.set_defaults(command=check)


def check(options: argparse.Namespace) -> int:
    """Say of every scenario whether it can be played; 2 if one cannot."""
    wrong = False
    for name in options.scenarios:
        try:
            load(name)
        except UserError as error:
            print(error, file=sys.stderr)
            wrong = True
        else:
            print(f"{name}: ok")
    return WRONG_INPUT if wrong else OK


def load(name: str) -> rules.Scenario:
    """A scenario from a file, or one that is shipped; verdicts call it as the user does.

    Raises:
        UserError: there is neither, or something is wrong with it.
    """
    with found(name) as path:
        if not path.exists() and path.name == name:
            raise unknown("file or shipped scenario", name, scenarios())
        return replace(rules.load(path), file=Path(name))


def found(name: str) -> AbstractContextManager[Path]:
    """The path of a scenario; one that is shipped has a path only meanwhile."""
    if name in scenarios() and not Path(name).exists():
        return scenario_file(name)
    return nullcontext(Path(name))


def add_schema(parser: Parser) -> None:
    """schema."""
    parser.add_argument("file", nargs="?", choices=("scenario", "bench"), default="scenario")
    parser.set_defaults(command=schema)


def schema(options: argparse.Namespace) -> int:
    """Print the JSON Schema of the files that users write, for their editors."""
    # pydantic, which a run without a scenario starts without
    from canopen_twins.files.table import json_schema  # noqa: PLC0415
    from canopen_twins.scenario.schema import BenchFile, ScenarioFile  # noqa: PLC0415

    table = BenchFile if options.file == "bench" else ScenarioFile
    print(json.dumps(json_schema(table), indent=2))
    return OK
