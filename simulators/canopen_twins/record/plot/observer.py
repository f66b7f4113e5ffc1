"""Looks at the nodes of a run after every moment at which something happened; leaves no trace."""

from math import isfinite

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.record.plot.run import Run, View
from canopen_twins.scenario import Player, PlayerEvent

GRAIN = 1  # microsecond: a moment of the clock is over when the next one begins


class Observer:
    """Begins before anything has happened on the segment; there is nothing to be stopped.

    Between two moments of the clock nothing changes but by a frame from outside, so nothing escapes
    it, and a device at rest costs nothing.
    """

    def __init__(self, segment: Segment[Node], player: Player | None) -> None:
        self.views = [View(node) for node in segment.nodes]
        self._clock = segment.clock
        self._begin = self._clock.ticks
        segment.listeners.append(self._hear)
        self._player = player
        if player is not None:
            player.listeners.append(self._follow)
        self._plan(self._begin + GRAIN)

    @property
    def duration(self) -> float:
        """Seconds since the beginning."""
        return max(self._clock.ticks - self._begin, GRAIN) / MICROSECONDS

    @property
    def run(self) -> Run:
        """What there is to be drawn by now."""
        if self._player is None:
            return Run("", None, self.views, self.duration)
        name, verdict = self._player.scenario.name, self._player.verdict
        return Run(name, verdict, self.views, self.duration)

    def _look(self) -> None:
        time = (self._clock.ticks - GRAIN - self._begin) / MICROSECONDS
        for view in self.views:
            view.look(time)
        upcoming = self._clock.next_tick
        if isfinite(upcoming):
            self._plan(int(upcoming) + GRAIN)

    def _plan(self, tick: int) -> None:
        self._due, self._timer = tick, self._clock.at_tick(tick, self._look)

    def _follow(self, event: PlayerEvent) -> None:
        for view in self.views:
            if event.kind == "inject" and event.node == view.name:
                view.hit(event.time, event.fields)

    def _hear(self, frame: Frame, sender: str) -> None:
        if not self._timer.pending or self._due > self._clock.ticks + GRAIN:  # from outside
            self._timer.cancel()
            self._plan(self._clock.ticks + GRAIN)
        for view in self.views:
            view.hear(self.duration, frame, sender)
