"""One step being carried out: what its action acts on, and whom it tells."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from canopen_twins.bus.clock import microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.scenario.expect import Expectation
from canopen_twins.scenario.player.client import Job
from canopen_twins.scenario.player.happenings import Position
from canopen_twins.scenario.player.tools import Tools
from canopen_twins.scenario.player.trigger import Trigger
from canopen_twins.scenario.player.window import Window
from canopen_twins.scenario.scenario import Condition, Step
from canopen_twins.scenario.sdo import Answer, Transfer
from canopen_twins.scenario.verdict import Finding, Kind


class ExecutionListener(Protocol):
    """Whom an execution tells what outlives it."""

    def opens(self, window: Window) -> None:
        """Something is expected from now on."""

    def decides(self, window: Window, finding: Finding, tick: int) -> None:
        """An expectation is over."""

    def heals(self, tick: int) -> None:
        """Something heals by itself at a microsecond to come."""

    def breaks(self, step: Step) -> None:
        """It could not be carried out."""


class Execution:
    """The `Context` of the action of a step; `answered` is called when it asks nobody any more."""

    def __init__(
        self, step: Step, tools: Tools, listener: ExecutionListener, answered: Callable[[], None]
    ) -> None:
        self.since = Position(-1, 0)
        """Where the present begins, if it is at this microsecond."""
        self.asks = 0
        """Jobs that the client has not done yet."""
        self.broken = False
        self._step = step
        self._tools = tools
        self._listener = listener
        self._all_answered = answered

    def run(self) -> None:
        """Carry the step out once."""
        try:
            self._step.action.carry_out(self)
        except UserError as refusal:
            self.report(Finding(Kind.ERROR, str(refusal)))

    @property
    def node(self) -> Node:
        """The node the step is about."""
        return self._tools.nodes[self._step.node]

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus as a master."""
        self._tools.send(frame)

    def ask(
        self,
        transfers: Sequence[Transfer],
        patience: float,
        answered: Callable[[int, Answer], bool],
    ) -> None:
        """SDO transfers with the node, behind those of the steps before."""
        self.asks += 1
        client = self._tools.clients[self._step.node]
        client.ask(Job(transfers, patience, answered, self._answered))

    def _answered(self) -> None:
        self.asks -= 1
        self._all_answered()

    def inject(
        self, faults: Mapping[str, Mapping[str, Any]], lasts: float | Condition | None
    ) -> None:
        """Let things go wrong with the node; a condition heals them once it is met."""
        tools, here = self._tools, self._tools.happenings.position
        tools.healing.inject(self.node, faults)
        if lasts is None:
            return
        heal = tools.healing.plan(self.node, faults)
        if isinstance(lasts, Condition):
            trigger = Trigger(lasts, tools, lambda: tools.clock.at_tick(tools.clock.ticks, heal))
            trigger.set(here)
        else:
            tick = tools.clock.ticks + microseconds(lasts)
            tools.clock.at_tick(tick, heal)
            self._listener.heals(tick)

    def clear(self, fault: str | None) -> None:
        """Take a fault of the node away, or all of them."""
        self._tools.healing.clear(self.node, fault)

    def report(self, finding: Finding) -> None:
        """Take what has been decided at once."""
        self._tools.judge.decide(self._step, finding, self._tools.clock.ticks)
        if finding.kind is Kind.ERROR:
            self.broken = True
            self._listener.breaks(self._step)

    def watch_for(self, expectation: Expectation) -> None:
        """Take what will be decided."""
        tools = self._tools
        window = Window(self._step, expectation, tools, self._listener.decides)
        self._listener.opens(window)
        window.open(self.since)
