"""CANopen state machine of the gateway: five states, commands from two sides (chapter 3)."""

from collections.abc import Mapping
from enum import Enum


class GatewayState(Enum):
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

ALWAYS: Mapping[Trigger, GatewayState] = {
    GovernorCommand.UNDEFINED: GatewayState.UNDEFINED,
    GovernorCommand.INIT: GatewayState.INIT,
    Trouble.ABORT: GatewayState.UNDEFINED,
}
RESETTABLE: Mapping[Trigger, GatewayState] = {
    **ALWAYS,
    MasterCommand.RESET_NODE: GatewayState.INIT,  # both the same
    MasterCommand.RESET_COMMUNICATION: GatewayState.INIT,
}

# A trigger that a state does not name changes nothing.
NEXT: Mapping[GatewayState, Mapping[Trigger, GatewayState]] = {
    GatewayState.UNDEFINED: ALWAYS,
    GatewayState.INIT: {**ALWAYS, GovernorCommand.PRE_OPERATIONAL: GatewayState.PRE_OPERATIONAL},
    GatewayState.PRE_OPERATIONAL: {
        **RESETTABLE,
        MasterCommand.OPERATIONAL: GatewayState.OPERATIONAL,
        MasterCommand.STOP: GatewayState.STOPPED,
        Trouble.SDO_OVERFLOW: GatewayState.STOPPED,
    },
    GatewayState.OPERATIONAL: {
        **RESETTABLE,
        MasterCommand.PRE_OPERATIONAL: GatewayState.PRE_OPERATIONAL,
        MasterCommand.STOP: GatewayState.STOPPED,
        Trouble.CANOPEN_BUS: GatewayState.PRE_OPERATIONAL,
        Trouble.SDO_OVERFLOW: GatewayState.STOPPED,
    },
    GatewayState.STOPPED: {
        **RESETTABLE,
        MasterCommand.PRE_OPERATIONAL: GatewayState.PRE_OPERATIONAL,
        MasterCommand.OPERATIONAL: GatewayState.OPERATIONAL,
        Trouble.CANOPEN_BUS: GatewayState.PRE_OPERATIONAL,
    },
}


STATE_PARAMETERS: Mapping[int, GatewayState] = {
    12401: GatewayState.STOPPED,
    12402: GatewayState.INIT,
    12403: GatewayState.PRE_OPERATIONAL,
    12404: GatewayState.OPERATIONAL,
}

COMMUNICATING = (GatewayState.PRE_OPERATIONAL, GatewayState.OPERATIONAL, GatewayState.STOPPED)


def state_word(state: GatewayState) -> int:
    """Parameter 12400: bit k stands for 12401+k, nothing for Undefined (A-25)."""
    return sum((state is each) << (number - 12401) for number, each in STATE_PARAMETERS.items())
