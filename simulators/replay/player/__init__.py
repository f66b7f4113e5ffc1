"""Plays a scenario on a segment, whoever drives its clock: simulated time or real time."""

from simulators.replay.player.events import Event
from simulators.replay.player.player import LONGEST, Player

__all__ = ["LONGEST", "Event", "Player"]
