"""CANopen state machine of the gateway: five states, commands from two sides (chapter 3)."""

from collections.abc import Mapping
from enum import Enum


class State(Enum):
    """The states of chapter 3."""

    UNDEFINED = "Undefined"
    INIT = "Init"
    PRE_OPERATIONAL = "Pre-Operational"
    OPERATIONAL = "Operational"
    STOPPED = "Stopped"


class GovernorCommand(Enum):
    """What the governor may order: nothing else."""

    UNDEFINED = "Undefined"
    INIT = "Init"
    PRE_OPERATIONAL = "Pre-Operational"


class MasterCommand(Enum):
    """What the CANopen master may order, with the first byte of its NMT telegram (Figure 3)."""

    OPERATIONAL = 0x01
    STOP = 0x02
    PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    RESET_COMMUNICATION = 0x82


class Trouble(Enum):
    """What the gateway draws the consequence of by itself (9.4, 9.5)."""

    ABORT = "3070 3071 3073 3076 3077 3078 3090 3093 3094"
    CANOPEN_BUS = "3072"
    SDO_OVERFLOW = "3073, SDO transmission buffer"


Trigger = GovernorCommand | MasterCommand | Trouble

ALWAYS: Mapping[Trigger, State] = {
    GovernorCommand.UNDEFINED: State.UNDEFINED,
    GovernorCommand.INIT: State.INIT,
    Trouble.ABORT: State.UNDEFINED,
}
RESETS: Mapping[Trigger, State] = {  # both the same
    MasterCommand.RESET_NODE: State.INIT,
    MasterCommand.RESET_COMMUNICATION: State.INIT,
}

# A trigger that a state does not name changes nothing.
NEXT: Mapping[State, Mapping[Trigger, State]] = {
    State.UNDEFINED: ALWAYS,
    State.INIT: {**ALWAYS, GovernorCommand.PRE_OPERATIONAL: State.PRE_OPERATIONAL},
    State.PRE_OPERATIONAL: {
        **ALWAYS,
        **RESETS,
        MasterCommand.OPERATIONAL: State.OPERATIONAL,
        MasterCommand.STOP: State.STOPPED,
        Trouble.SDO_OVERFLOW: State.STOPPED,
    },
    State.OPERATIONAL: {
        **ALWAYS,
        **RESETS,
        MasterCommand.PRE_OPERATIONAL: State.PRE_OPERATIONAL,
        MasterCommand.STOP: State.STOPPED,
        Trouble.CANOPEN_BUS: State.PRE_OPERATIONAL,
        Trouble.SDO_OVERFLOW: State.STOPPED,
    },
    State.STOPPED: {
        **ALWAYS,
        **RESETS,
        MasterCommand.PRE_OPERATIONAL: State.PRE_OPERATIONAL,
        MasterCommand.OPERATIONAL: State.OPERATIONAL,
        Trouble.CANOPEN_BUS: State.PRE_OPERATIONAL,
    },
}


class Machine:
    """The state machine itself."""

    def __init__(self) -> None:
        self.state = State.UNDEFINED

    def handle(self, trigger: Trigger) -> None:
        """Go where the trigger leads from here."""
        self.state = NEXT[self.state].get(trigger, self.state)


STATE_PARAMETERS: Mapping[int, State] = {
    12401: State.STOPPED,
    12402: State.INIT,
    12403: State.PRE_OPERATIONAL,
    12404: State.OPERATIONAL,
}

COMMUNICATING = (State.PRE_OPERATIONAL, State.OPERATIONAL, State.STOPPED)


def state_word(state: State) -> int:
    """Parameter 12400: bit k stands for 12401+k, nothing for Undefined (A-25)."""
    return sum((state is each) << (number - 12401) for number, each in STATE_PARAMETERS.items())
