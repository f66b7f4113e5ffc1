"""What a player does, told as it happens."""

from collections.abc import Mapping
from typing import NamedTuple


class Event(NamedTuple):
    """Something that is not to be seen in the frames.

    The kinds and their fields: `step` (line, what), `inject` (fault, parameters), `clear` (fault),
    `state` (state), `outcome` (verdict, line, what, seen).
    """

    time: float
    """Seconds of the scenario."""
    node: str
    """Its name; empty if it is about none."""
    kind: str
    fields: Mapping[str, object]
