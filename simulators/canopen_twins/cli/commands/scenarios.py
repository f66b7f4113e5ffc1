"""Scenarios: find them, and say what is wrong with them."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from canopen_twins import scenario as replay
from canopen_twins.cli.exit_codes import OK, WRONG_INPUT
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.shipped import scenario_file, scenarios


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


def load(name: str) -> replay.Scenario:
    """A scenario from a file, or one that is shipped; verdicts call it as the user does.

    Raises:
        UserError: there is neither, or something is wrong with it.
    """
    if name in scenarios() and not Path(name).exists():
        with scenario_file(name) as path:
            return replace(replay.load(path), file=Path(name))
    if not Path(name).exists() and Path(name).name == name:
        raise unknown("file or shipped scenario", name, scenarios())
    return replay.load(Path(name))
