"""States of the output stage, what leads from one to the next, and the limits that hold it."""

from collections.abc import Mapping
from enum import Enum, auto


class Mode(Enum):
    """The limit that holds the output (Tab. 60); OFF when nothing does."""

    OFF = auto()
    VOLTAGE = auto()
    CURRENT = auto()
    POWER = auto()


class StageState(Enum):
    """States of a unit; in READY and ERROR the output is isolated."""

    POWERUP = auto()
    READY = auto()
    RUN = auto()
    WARN = auto()  # as RUN, with a warning
    ERROR = auto()


class StageEvent(Enum):
    """What can move a unit from one state to another; any other pair changes nothing."""

    BOOTED = auto()
    RUN = auto()
    STOP = auto()
    WARN = auto()
    CLEAR = auto()  # no error and no warning is left
    TRIP = auto()


TRANSITIONS: Mapping[StageState, Mapping[StageEvent, StageState]] = {
    StageState.POWERUP: {
        StageEvent.BOOTED: StageState.READY,
        StageEvent.TRIP: StageState.ERROR,
    },
    StageState.READY: {
        StageEvent.RUN: StageState.RUN,
        StageEvent.TRIP: StageState.ERROR,
    },
    StageState.RUN: {
        StageEvent.STOP: StageState.READY,
        StageEvent.WARN: StageState.WARN,
        StageEvent.TRIP: StageState.ERROR,
    },
    StageState.WARN: {
        StageEvent.STOP: StageState.READY,
        StageEvent.CLEAR: StageState.RUN,
        StageEvent.TRIP: StageState.ERROR,
    },
    StageState.ERROR: {StageEvent.CLEAR: StageState.READY},  # 7.3.9: never to RUN
}
