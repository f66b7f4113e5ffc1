"""Whether a master is there at all, for a scenario that is about one."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node

if TYPE_CHECKING:
    from canopen_twins.scenario import Player

log = logging.getLogger(__name__)

SILENCE = 2.0  # seconds


class MasterWatch:
    """Says so when nobody has been heard for a while, and has the verdict say so to its end.

    Args:
        segment: Where the frames of a master are those from outside.
        player: Of the scenario, if there is one.
    """

    def __init__(self, segment: Segment[Node], player: Player | None) -> None:
        self._segment = segment
        self._player = player if player is not None and player.is_about_a_master else None
        if self._player is not None:
            segment.listeners.append(self._hear)

    def start(self) -> None:
        """The twins are on the bus."""
        if self._player is not None:
            self._segment.clock.after(SILENCE, self._look)

    def _hear(self, frame: Frame, sender: str) -> None:
        """The first frame settles it; whoever sends none is no master yet."""
        if not sender and self._player is not None:
            self._player.no_master_heard = False
            self._player = None
            self._segment.clock.after(0, lambda: self._segment.listeners.remove(self._hear))

    def _look(self) -> None:
        if self._player is not None:
            self._player.no_master_heard = True
            log.warning("no master heard for %.0f s; still waiting for one", SILENCE)
