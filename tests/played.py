"""Shipped scenarios, each played once however many tests hold something against its run."""

from collections.abc import Callable
from functools import cache
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from canopen_twins.record.folder import record
from canopen_twins.record.manifest import Manifest
from canopen_twins.record.plot.run import Run as DrawnRun
from canopen_twins.scenario import Scenario, Verdict, load, play

SCENARIOS = sorted(Path(__file__).parents[1].glob("scenarios/*.yaml"))


class Played(NamedTuple):
    """A run that was recorded, and looked at as for a picture."""

    scenario: Scenario
    verdict: Verdict
    trace: str
    record: Path
    observer: DrawnRun


def player(folder: Path) -> Callable[[Path], Played]:
    """Plays a file when it is asked for the first time; the records go to a folder."""

    @cache
    def played(path: Path) -> Played:
        scenario, trace, observers = load(path), StringIO(), []
        participants = {name: spec.create() for name, spec in scenario.nodes.items()}
        told = Manifest.of("play", scenario, participants)
        with record(folder / path.stem, told, path.read_bytes(), {}) as recorder:
            attached = [recorder, lambda *run: observers.append(DrawnRun(*run))]
            verdict = play(scenario, trace, attached)
        return Played(scenario, verdict, trace.getvalue(), folder / path.stem, *observers)

    return played
