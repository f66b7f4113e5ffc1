"""What a device shows of itself over time: quantities as curves, its own state as a band."""

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import NamedTuple

Read = Callable[[], float | None]
"""A value in engineering units; None while there is none."""


class Curve(NamedTuple):
    """A quantity, read from the model whenever somebody looks; reading changes nothing."""

    label: str
    unit: str
    actual: Read
    wanted: Read | None = None
    """The set value beside it, if there is one."""


class Mood(IntEnum):
    """How a state is to be seen, from harmless to bad; it gives the colour."""

    OFF = 0
    WAITING = 1
    ACTIVE = 2
    WARNING = 3
    ERROR = 4


class Band(NamedTuple):
    """A state: the word for it, and how it is to be seen."""

    label: str
    mood: Mood


class Chart(NamedTuple):
    """What is drawn of a device: the same curves in the same order, whenever it is asked for."""

    curves: Sequence[Curve] = ()
    band: Callable[[], Band] | None = None
    """The device's own state at this moment, beside that of NMT."""
