"""A scenario as it is played: nodes, and steps in the order of their times."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple

from simulators.device import Device
from simulators.node import Node
from simulators.replay.master import Master
from simulators.replay.verdict import Finding
from simulators.wire import Frame


class Stage(NamedTuple):
    """What a step acts on, and whom it tells."""

    node: Node
    master: Master
    report: Callable[[Finding], None]
    """Takes what has been decided at once."""
    watch: Callable[[Expectation], None]
    """Takes what will be decided."""


class Action:
    """What a step does; `str` says it in words."""

    def __str__(self) -> str:
        return type(self).__name__.lower()

    def carry_out(self, stage: Stage) -> None:
        """Do it, now.

        Raises:
            UserError: it cannot be done.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class Expectation(Action):
    """What should be seen of a node within a time, beginning with the moment of its step.

    Whatever is sent at that moment counts, before the step's turn or after; so does what is sent
    at the last moment. A look at the dictionary shows it as it is when a moment is over.
    """

    within: float
    """Seconds."""

    looks: ClassVar[bool] = False
    """Whether it looks at the dictionary, beside hearing frames."""

    def carry_out(self, stage: Stage) -> None:
        """Watch from now on."""
        stage.watch(self)

    def on_frame(self, frame: Frame, node: Node) -> Finding | None:
        """What a frame of the node decides."""
        return None

    def on_look(self, node: Node) -> Finding | None:
        """What a look at the node decides, once a cycle of its device."""
        return None

    def at_end(self, frames: list[Frame], node: Node) -> Finding:
        """What remains to be said when the time is over, with the frames of the node in it."""
        raise NotImplementedError


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
    """One action at its time."""

    at: float
    """Seconds from the beginning."""
    node: str
    """The name of the node that it is about."""
    action: Action
    note: str
    line: int
    """Of the file."""


@dataclass(frozen=True)
class Scenario:
    """A story: who takes part, and what happens when."""

    file: Path
    name: str
    note: str
    nodes: Mapping[str, NodeSpec]
    steps: tuple[Step, ...]

    @property
    def duration(self) -> float:
        """Seconds until the last step is done and the last expectation decided."""
        return max((step.at + _lasts(step.action) for step in self.steps), default=0.0)


def _lasts(action: Action) -> float:
    return action.within if isinstance(action, Expectation) else 0.0
