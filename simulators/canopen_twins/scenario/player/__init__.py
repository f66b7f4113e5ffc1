"""Plays a scenario on a segment, whoever drives its clock: simulated time or real time."""

from canopen_twins.scenario.player.events import Event
from canopen_twins.scenario.player.player import LONGEST, Player

__all__ = ["LONGEST", "Event", "Player"]
