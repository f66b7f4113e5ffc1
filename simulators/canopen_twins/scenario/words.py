"""Words of scenarios for what the protocol has as numbers, and for switches."""

from collections.abc import Callable, Mapping

from canopen_twins.device.node import Node
from canopen_twins.slave.service import State

STATES: Mapping[str, State] = {state.lower(): state for state in State}
HEARTBEATS: Mapping[str, State] = {
    word: state for word, state in STATES.items() if state is not State.INITIALISING
}
SWITCHES: Mapping[str, Callable[[Node], None]] = {"on": Node.power_on, "off": Node.power_off}
ALL_FAULTS = "all"
ANY, NONE = "any", "none"
MASTER = "master"
EMCY_FIELDS: Mapping[str, int] = {"code": 0xFFFF, "register": 0xFF, "detail": 0xFF_FFFF_FFFF}
"""The highest value of each."""
