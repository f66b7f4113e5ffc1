"""Scenarios, played in simulated time."""

import argparse

from canopen_twins import scenario as replay
from canopen_twins.cli.commands.announce import Announcer
from canopen_twins.cli.commands.kept import kept
from canopen_twins.cli.commands.progress import progress
from canopen_twins.cli.commands.scenarios import load
from canopen_twins.cli.exit_codes import FAILED, OK
from canopen_twins.errors import UserError
from canopen_twins.record.plot import Plot

OF_ONE_RUN = ("trace", "record", "plot")


def play(options: argparse.Namespace) -> int:
    """Play every scenario, the trace first and then the verdict; 1 if one has failed.

    Raises:
        UserError: something that is kept of one run is wanted of several, or cannot be.
    """
    for name in OF_ONE_RUN:
        if getattr(options, name) and len(options.scenarios) > 1:
            raise UserError(f"--{name} keeps one run: name one scenario")
    announcer = Announcer(options)
    plot = Plot(options.plot) if options.plot else None
    scenarios = [load(name) for name in options.scenarios]
    verdicts = [_play(scenario, options, announcer, plot) for scenario in scenarios]
    announcer.end()
    return OK if all(verdict.ok for verdict in verdicts) else FAILED


def _play(
    scenario: replay.Scenario,
    options: argparse.Namespace,
    announcer: Announcer,
    plot: Plot | None,
) -> replay.Verdict:
    participants = {name: spec.create() for name, spec in scenario.nodes.items()}
    with kept(options, "play", scenario, participants) as observers, progress() as line:
        everybody = [*observers, line.attach, *([plot.begin] if plot else [])]
        verdict = replay.play(scenario, announcer.trace, everybody, line.tell)
    announcer.tell(verdict)
    if plot is not None:
        plot.save()
    return verdict
