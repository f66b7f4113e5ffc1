"""Scenarios: play them, or say what is wrong with them."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from simulators import replay
from simulators.commands.kept import kept
from simulators.commands.progress import progress
from simulators.errors import UserError, unknown
from simulators.resources import scenario_file, scenarios

FAILED, WRONG_INPUT = 1, 2


def play(options: argparse.Namespace) -> int:
    """Play every scenario, the trace first and then the verdict; 1 if one has failed."""
    failed = False
    if len(options.scenarios) > 1 and (options.trace or options.record):
        raise UserError("one run at a time can be kept: --trace and --record want one scenario")
    for scenario in [load(name) for name in options.scenarios]:
        cast = {name: spec.create() for name, spec in scenario.nodes.items()}
        with kept(options, "play", scenario, cast) as observers, progress() as line:
            verdict = replay.play(scenario, sys.stdout, [*observers, line.attach], line.tell)
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


def load(name: str) -> replay.Scenario:
    """A scenario from a file, or one that is shipped; verdicts call it as the user does.

    Raises:
        UserError: there is neither, or something is wrong with it.
    """
    if name in scenarios() and not Path(name).exists():
        with scenario_file(name) as path:
            return replace(replay.load(path), file=Path(name))
    if not Path(name).exists() and Path(name).name == name:
        raise unknown("scenario", name, scenarios())
    return replay.load(Path(name))
