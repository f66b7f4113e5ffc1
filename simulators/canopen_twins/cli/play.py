"""play: scenarios in simulated time, with a line of progress where they would be silent."""

import argparse
import faulthandler
import sys
import time
from collections.abc import Callable
from contextlib import closing
from typing import TextIO

from canopen_twins import scenario as simulated
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.command import FAILED, OK, PLOT, SCENARIO, Parser
from canopen_twins.cli.master import add_master, with_master
from canopen_twins.cli.results import Announcer, add_recording, add_reports, recording
from canopen_twins.cli.scenario_file import load
from canopen_twins.cli.words import Words, is_coloured
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.record.plot import Plot
from canopen_twins.scenario import Player, Scenario, Verdict

OF_ONE_RUN = ("trace", "record", "plot")
PERIOD = 0.5  # seconds of real time from one line of progress to the next
WIDTH = 60
STDERR = 2


def add_play(parser: Parser) -> None:
    """play."""
    parser.add_argument("scenarios", nargs="+", metavar="SCENARIO", help=SCENARIO)
    add_master(parser)
    add_reports(parser)
    text = "print frames as candump does, instead of what happens in words"
    parser.add_argument("--raw", action="store_true", help=text)
    parser.add_output("--plot", PLOT)
    add_recording(parser)
    parser.set_defaults(command=play)


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
    if not faulthandler.is_enabled():
        faulthandler.enable(STDERR)  # a master may end us: say where
    scenarios = [with_master(load(name), options.master) for name in options.scenarios]
    verdicts = [_play(scenario, options, announcer, plot) for scenario in scenarios]
    announcer.end()
    return OK if all(verdict.ok for verdict in verdicts) else FAILED


def _play(
    scenario: Scenario, options: argparse.Namespace, announcer: Announcer, plot: Plot | None
) -> Verdict:
    participants = {name: spec.create() for name, spec in scenario.nodes.items()}
    with (
        recording(options, "play", scenario, participants) as observers,
        closing(ProgressLine(sys.stderr)) as line,
    ):
        shown = sys.stderr.isatty() and not sys.stdout.isatty()  # frames say it themselves
        words = Words(print, is_coloured(sys.stdout), options.quiet)
        trace = announcer.trace if options.raw else None
        everybody = [
            *observers,
            *([line.attach] if shown else []),
            *([plot.begin] if plot else []),
            *([words.attach] if not options.raw and announcer.trace else []),
        ]
        verdict = simulated.play(scenario, trace, everybody, line.tell)
    announcer.tell(verdict)
    if plot is not None:
        plot.save()
    return verdict


class ProgressLine:
    """Tells how far a run has come, again and again in one line; silent until it is attached."""

    def __init__(self, stream: TextIO, wall: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._wall = wall
        self._due = wall() + PERIOD
        self._written = False
        self._player: Player | None = None

    def attach(self, segment: Segment[Node], player: Player) -> None:
        """It knows how long the run will be, as far as anybody does."""
        self._player = player

    def tell(self, now: float) -> None:
        """Write it anew, if it is time to."""
        if self._player is None or self._wall() < self._due:
            return
        self._due = self._wall() + PERIOD
        self._written = True
        total = max(now, self._player.horizon, self._player.scenario.duration or 0.0)
        self._write(f"{now:.0f} of {total:.0f} s simulated")

    def close(self) -> None:
        """Leave nothing of it."""
        if self._written:
            self._write("")

    def _write(self, text: str) -> None:
        self._stream.write(f"\r{text:{WIDTH}}\r")
        self._stream.flush()
