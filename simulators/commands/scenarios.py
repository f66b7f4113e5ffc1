"""Scenarios: play them, or say what is wrong with them."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from simulators import replay
from simulators.commands.announce import Announcer
from simulators.errors import UserError, unknown
from simulators.plot import Plot
from simulators.resources import scenario_file, scenarios

FAILED, WRONG_INPUT = 1, 2


def play(options: argparse.Namespace) -> int:
    """Play every scenario, the trace first and then the verdict; 1 if one has failed."""
    announcer, plot = Announcer(options), _plot(options)
    failed = False
    for scenario in [load(name) for name in options.scenarios]:
        verdict = replay.play(scenario, announcer.trace, [plot.begin] if plot else ())
        announcer.tell(verdict)
        if plot is not None:
            plot.save(scenario, verdict)
        failed = failed or not verdict.ok
    announcer.end()
    return FAILED if failed else 0


def _plot(options: argparse.Namespace) -> Plot | None:
    """The picture that is wanted.

    Raises:
        UserError: of several runs, or one that cannot be made.
    """
    if options.plot is None:
        return None
    if len(options.scenarios) > 1:
        raise UserError("--plot makes a picture of one run: name one scenario")
    return Plot(options.plot)


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
