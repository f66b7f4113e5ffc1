"""A scenario as it is played: nodes, and steps with their moments."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from canopen_twins.bench.python_master import PythonMaster
from canopen_twins.bus.clock import Stalls
from canopen_twins.device.device import Device
from canopen_twins.scenario.actions import Action
from canopen_twins.scenario.matchers import Condition


@dataclass(frozen=True)
class At:
    """A time of the scenario."""

    seconds: float


@dataclass(frozen=True)
class After:
    """So long after the step above has been carried out, the last time if it is repeated."""

    seconds: float


Moment = At | After | Condition


class EndsWith(StrEnum):
    """What is waited for, where a command runs beside a scenario; the other one is ended."""

    SCENARIO = "scenario"
    COMMAND = "command"


@dataclass(frozen=True)
class NodeSpec:
    """A device and the settings it is delivered with."""

    device: type[Device]
    settings: Mapping[str, object]

    def create(self) -> Device:
        """The device, with its power off."""
        return self.device(**self.settings)


@dataclass(frozen=True)
class Step:
    """One action at its moment, perhaps repeated."""

    moment: Moment
    node: str
    """The name of the node that it is about; empty if it is about none."""
    action: Action
    note: str
    line: int
    """Of the file."""
    every: float = 0.0
    """Seconds from one repetition to the next."""
    times: int = 1
    """How often it is carried out altogether."""


@dataclass(frozen=True)
class Whenever:
    """What is expected every time that something is seen."""

    condition: Condition
    seconds: float
    """How long after that it begins."""
    step: Step
    """The expectation, with its place in the file."""


@dataclass(frozen=True)
class Recovery:
    """What has to be so again in time; its moment is when everything has healed."""

    condition: Condition
    seconds: float
    line: int
    """Of the file."""


@dataclass(frozen=True)
class Space:
    """What a hunt lets go wrong, as far as the file says so."""

    weather: str = "rough"
    faults: tuple[str, ...] | None = None
    """These alone; None: those of the weather."""
    without: tuple[str, ...] = ()
    most: int | None = None
    """At once; None: as the weather has it."""
    settings: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """Values by the names of settings."""


@dataclass(frozen=True)
class Scenario:
    """Who takes part, and what happens when."""

    file: Path
    name: str
    note: str
    nodes: Mapping[str, NodeSpec]
    steps: tuple[Step, ...]
    cleanup: tuple[Step, ...] = ()
    """Carried out in the end, whatever came of the steps; the first one's moment is `After`."""
    disturbances: tuple[Step, ...] = ()
    """Each by itself; its moment, `At` or a condition from the beginning on, need not come."""
    always: tuple[Whenever, ...] = ()
    recovers: Recovery | None = None
    """When all has healed, at the end of `duration`."""
    covers: tuple[str, ...] = ()
    """The statements it is about."""
    seed: int = 1
    """What the file gives, or would have given; the reader has put it where it belongs."""
    duration: float | None = None
    """Seconds that the run lasts at least; None: conditions are waited for, a minute at most."""
    ends_with: EndsWith = EndsWith.SCENARIO
    """What ends a run that has a command beside it."""
    stalls: Stalls = Stalls.SKIP
    """Of a run in real time."""
    bit_rate: int | None = None
    """In bit/s, for the simulated bus; None: frames take no time."""
    bit_rate_line: int = 0
    """Of the file, where it stands."""
    arbitration: str | None = None
    """The name of who is first at one microsecond; empty: the lowest identifier. None: as sent."""
    arbitration_line: int = 0
    """Of the file, where it stands."""
    space: Space = Space()
    """What a hunt lets go wrong."""
    master: PythonMaster | None = None
    """Who is tested; None: whoever is on the bus, or nobody."""
    master_line: int = 1
    """Of the file, where it stands; its first one if somebody else has named it."""

    @property
    def ends_with_command(self) -> bool:
        """Whether a command that runs beside it ends the run."""
        return self.ends_with is EndsWith.COMMAND

    @property
    def length(self) -> float | None:
        """Seconds that the run lasts at least: `duration`, and the time to be back after it."""
        if self.recovers is None or self.duration is None:
            return self.duration
        return self.duration + self.recovers.seconds
