"""One step: it waits for its moment, and is carried out as often as it should be."""

from __future__ import annotations

from typing import Protocol

from simulators.clock import Timer, microseconds
from simulators.replay.player.alarm import Alarm
from simulators.replay.player.crew import Crew
from simulators.replay.player.performance import Court, Performance
from simulators.replay.player.senses import Position
from simulators.replay.scenario import Condition, Step

WHOLE_MOMENT = Position(-1, 0)


class Follower(Court, Protocol):
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

    def __init__(self, step: Step, crew: Crew, follower: Follower) -> None:
        self.step = step
        self.scheduled = self.over = False
        self._crew = crew
        self._follower = follower
        self._performance = Performance(step, crew, follower, self._end_if_done)
        self._rounds = 0
        self._timer: Timer | None = None
        self._alarm: Alarm | None = None

    @property
    def begun(self) -> bool:
        """Whether it has been carried out for the first time."""
        return self._rounds > 0

    @property
    def waiting(self) -> bool:
        """Whether it waits for a condition."""
        return self._alarm is not None and not self.scheduled

    @property
    def broken(self) -> bool:
        """Whether it could not be carried out."""
        return self._performance.broken

    @property
    def since(self) -> Position:
        """Behind what set it off, if that was at this microsecond."""
        return self._performance.since

    def schedule(self, tick: int, since: Position = WHOLE_MOMENT) -> None:
        """Carry it out at a microsecond; what happens there counts from a position on."""
        self.scheduled = True
        self._performance.since = since
        self._timer = self._crew.clock.at_tick(tick, self._carry_out)

    def watch(self, condition: Condition, since: Position) -> None:
        """Carry it out when a condition is met from a position on."""
        self._alarm = Alarm(condition, self._crew, self._set_off)
        self._alarm.set(since)

    def drop(self) -> None:
        """Carry it out no more."""
        self.over = True
        if self._timer is not None:
            self._timer.cancel()
        if self._alarm is not None:
            self._alarm.stop()

    def _set_off(self) -> None:
        here = self._crew.senses.position
        self.schedule(self._crew.clock.ticks, here)  # not in the middle of what happens
        self._follower.begins(self, here)

    def _carry_out(self) -> None:
        crew, step = self._crew, self.step
        if self._follower.stopped:
            return
        if not self.begun and self._alarm is None:
            self._follower.begins(self, crew.senses.position)
        self._rounds += 1
        if self._rounds < step.times:
            tick = crew.clock.ticks + microseconds(step.every)
            self._timer = crew.clock.at_tick(tick, self._carry_out)
        crew.tell(step.node, "step", {"line": step.line, "what": str(step.action)})
        self._performance.give()
        self._end_if_done()

    def _end_if_done(self) -> None:
        if self._rounds == self.step.times and not self._performance.asks and not self.over:
            self.over = True
            self._follower.ends(self)
