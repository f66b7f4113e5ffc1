"""Scenarios: play them, or say what is wrong with them."""

import argparse
import dataclasses
import sys
from pathlib import Path

from simulators import replay
from simulators.errors import UserError, unknown
from simulators.replay.scenario import Scenario
from simulators.resources import scenario_file, scenarios

FAILED, WRONG_INPUT = 1, 2


def play(options: argparse.Namespace) -> int:
    """Play every scenario, the trace first and then the verdict; 1 if one has failed."""
    failed = False
    for scenario in [load(name) for name in options.scenarios]:
        verdict = replay.play(scenario, sys.stdout)
        print(verdict)
        failed = failed or not verdict.ok
    return FAILED if failed else 0


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
    return WRONG_INPUT if wrong else 0


def load(name: str) -> Scenario:
    """A scenario from a file, or one that is shipped; its file is called as the user calls it.

    Raises:
        UserError: there is neither, or the file has mistakes.
    """
    if Path(name).exists() or "/" in name:
        return replay.load(Path(name))
    if name not in scenarios():
        raise unknown("scenario", name, scenarios())
    with scenario_file(name) as path:
        return dataclasses.replace(replay.load(path), file=Path(name))
