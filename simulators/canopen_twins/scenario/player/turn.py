"""One step: it waits for its moment, and is carried out as often as it should be."""

from __future__ import annotations

from typing import Protocol

from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.scenario.player.execution import Execution, ExecutionListener
from canopen_twins.scenario.player.happenings import Position
from canopen_twins.scenario.player.tools import Tools
from canopen_twins.scenario.player.trigger import Trigger
from canopen_twins.scenario.scenario import Condition, Step

WHOLE_MOMENT = Position(-1, 0)


class StepListener(ExecutionListener, Protocol):
    """What a turn tells of itself to those it belongs to."""

    @property
    def stopped(self) -> bool:
        """Whether nothing is carried out any more."""

    def begins(self, turn: Turn, since: Position) -> None:
        """Its moment has come: the next one may watch from this position on."""

    def ends(self, turn: Turn) -> None:
        """It has been carried out for the last time."""


class Turn:
    """`scheduled`: its moment is known; `over`: it has been carried out, or never will be."""

    def __init__(self, step: Step, tools: Tools, listener: StepListener) -> None:
        self.step = step
        self.scheduled = self.over = False
        self._tools = tools
        self._listener = listener
        self._execution = Execution(step, tools, listener, self._end_if_done)
        self._rounds = 0
        self._timer: Timer | None = None
        self._trigger: Trigger | None = None

    @property
    def begun(self) -> bool:
        """Whether it has been carried out for the first time."""
        return self._rounds > 0

    @property
    def waiting(self) -> bool:
        """Whether it waits for a condition."""
        return self._trigger is not None and not self.scheduled

    @property
    def broken(self) -> bool:
        """Whether it could not be carried out."""
        return self._execution.broken

    @property
    def since(self) -> Position:
        """Behind what set it off, if that was at this microsecond."""
        return self._execution.since

    def schedule(self, tick: int, since: Position = WHOLE_MOMENT) -> None:
        """Carry it out at a microsecond; what happens there counts from a position on."""
        self.scheduled = True
        self._execution.since = since
        self._timer = self._tools.clock.at_tick(tick, self._carry_out)

    def watch(self, condition: Condition, since: Position) -> None:
        """Carry it out when a condition is met from a position on."""
        self._trigger = Trigger(condition, self._tools, self._set_off)
        self._trigger.set(since)

    def drop(self) -> None:
        """Carry it out no more."""
        self.over = True
        if self._timer is not None:
            self._timer.cancel()
        if self._trigger is not None:
            self._trigger.stop()

    def _set_off(self) -> None:
        here = self._tools.happenings.position
        self.schedule(self._tools.clock.ticks, here)  # not in the middle of what happens
        self._listener.begins(self, here)

    def _carry_out(self) -> None:
        tools, step = self._tools, self.step
        if self._listener.stopped:
            return
        if not self.begun and self._trigger is None:
            self._listener.begins(self, tools.happenings.position)
        self._rounds += 1
        if self._rounds < step.times:
            tick = tools.clock.ticks + microseconds(step.every)
            self._timer = tools.clock.at_tick(tick, self._carry_out)
        tools.tell(step.node, "step", {"line": step.line, "what": str(step.action)})
        self._execution.run()
        self._end_if_done()

    def _end_if_done(self) -> None:
        if self._rounds == self.step.times and not self._execution.asks and not self.over:
            self.over = True
            self._listener.ends(self)
