"""What can be seen of a node and of its master: one vocabulary for conditions and expectations."""

from simulators.replay.signs.commands import COMMANDS, Commanded, Written
from simulators.replay.signs.frames import AnyFrame, EmcyLike, FrameLike, HeartbeatLike
from simulators.replay.signs.looks import Entered, Holds
from simulators.replay.signs.sign import Changed, Happening, Sent, Sign, Wrote
from simulators.replay.signs.wanted import Anything, Range, Text, Wanted

__all__ = [
    "COMMANDS",
    "AnyFrame",
    "Anything",
    "Changed",
    "Commanded",
    "EmcyLike",
    "Entered",
    "FrameLike",
    "Happening",
    "HeartbeatLike",
    "Holds",
    "Range",
    "Sent",
    "Sign",
    "Text",
    "Wanted",
    "Written",
    "Wrote",
]
