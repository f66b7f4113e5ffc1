"""The scenario that the port has started, or that of the run: what has come of it so far."""

from collections.abc import Mapping
from typing import Any

from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.live.control.events import Events
from canopen_twins.scenario import Player, Scenario
from canopen_twins.scenario.started import start_now, stop_now
from canopen_twins.scenario.verdict import as_object


class Scenarios:
    """One at a time; all of it is for the thread of the twins."""

    def __init__(self, segment: Segment[Node], events: Events, player: Player | None) -> None:
        """`player` is that of the run, if it has one."""
        self._segment = segment
        self._events = events
        self._player = player
        self._of_run = player  # the run looks after it
        self._over: Mapping[str, Any] | None = None
        if player is not None:
            events.follow(player)

    @property
    def running(self) -> bool:
        """Whether there is one that is not over; one that is over leaves the bus."""
        if self._player is None or self._over is not None:
            return False
        if self._player.done:
            self._over = as_object(self._player.verdict)
            if self._player is not self._of_run:
                self._player.leave()
        return self._over is None

    def start(self, scenario: Scenario, text: str) -> int:
        """Begin one; the moment in microseconds.

        Raises:
            UserError: another one is not over yet.
        """
        if self.running:
            assert self._player is not None
            raise UserError(f"{self._player.scenario.file} is not over yet: stop it first")
        self._player, self._over = start_now(self._segment, scenario, text), None
        self._events.follow(self._player)
        return self._segment.clock.ticks

    def stop(self) -> int:
        """End it before its time; the moment in microseconds.

        Raises:
            UserError: there is none that is not over.
        """
        if not self.running or self._player is None:
            raise UserError("no scenario is running")
        stop_now(self._segment, self._player)
        return self._segment.clock.ticks

    @property
    def told(self) -> Mapping[str, Any] | None:
        """Whether it is running, and its verdict so far; none before there was one."""
        if self._player is None:
            return None
        running = self.running
        verdict = self._over if self._over is not None else as_object(self._player.verdict)
        return {"running": running, **verdict}
