"""What the output stage can be doing, and what leads from one state to the next."""

from collections.abc import Mapping
from enum import Enum, auto


class Mode(Enum):
    """The limit that holds the output (Tab. 60); OFF when nothing does."""

    OFF = auto()
    VOLTAGE = auto()
    CURRENT = auto()
    POWER = auto()


class State(Enum):
    """States of a unit; in READY and ERROR the output is isolated."""

    POWERUP = auto()
    READY = auto()
    RUN = auto()
    WARN = auto()  # as RUN, with a warning
    ERROR = auto()


class Event(Enum):
    """What can move a unit from one state to another; any other pair changes nothing."""

    BOOTED = auto()
    RUN = auto()
    STOP = auto()
    WARN = auto()
    CLEAR = auto()  # no error and no warning is left
    TRIP = auto()


TRANSITIONS: Mapping[State, Mapping[Event, State]] = {
    State.POWERUP: {Event.BOOTED: State.READY, Event.TRIP: State.ERROR},
    State.READY: {Event.RUN: State.RUN, Event.TRIP: State.ERROR},
    State.RUN: {Event.STOP: State.READY, Event.WARN: State.WARN, Event.TRIP: State.ERROR},
    State.WARN: {Event.STOP: State.READY, Event.CLEAR: State.RUN, Event.TRIP: State.ERROR},
    State.ERROR: {Event.CLEAR: State.READY},  # 7.3.9: never straight back to RUN
}
