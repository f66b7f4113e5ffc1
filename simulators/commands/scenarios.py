"""Scenarios: play them, or say what is wrong with them."""

import argparse
import sys
from pathlib import Path

from simulators import replay
from simulators.errors import UserError, unknown
from simulators.resources import scenario_file, scenarios

FAILED, WRONG_INPUT = 1, 2


def play(options: argparse.Namespace) -> int:
    """Play every scenario, the trace first and then the verdict; 1 if one has failed."""
    loaded = [replay.load(find(name)) for name in options.scenarios]
    failed = False
    for scenario in loaded:
        verdict = replay.play(scenario, sys.stdout)
        print(verdict)
        failed = failed or not verdict.ok
    return FAILED if failed else 0


def check(options: argparse.Namespace) -> int:
    """Say of every scenario whether it can be played; 2 if one cannot."""
    wrong = False
    for name in options.scenarios:
        try:
            replay.load(find(name))
        except UserError as error:
            print(error, file=sys.stderr)
            wrong = True
        else:
            print(f"{name}: ok")
    return WRONG_INPUT if wrong else 0


def find(name: str) -> Path:
    """The path of a scenario: a file, or one that is shipped.

    Raises:
        UserError: there is neither.
    """
    if Path(name).exists() or "/" in name:
        return Path(name)
    if name in scenarios():
        with scenario_file(name) as path:
            return path
    raise unknown("scenario", name, scenarios())
