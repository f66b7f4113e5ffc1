"""What every step of a run works with."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.scenario.player.client import Client
from canopen_twins.scenario.player.happenings import Happenings
from canopen_twins.scenario.player.healing import Healing
from canopen_twins.scenario.player.judge import Judge


class Tools(NamedTuple):
    """One of each for all steps."""

    nodes: Mapping[str, Node]
    clock: Clock
    happenings: Happenings
    clients: Mapping[str, Client]
    """By the names of the nodes they ask."""
    healing: Healing
    judge: Judge
    send: Callable[[Frame], None]
    """Puts a frame on the bus as the scenario's master."""
    tell: Callable[[str, str, Mapping[str, object]], None]
    """Takes the node, kind and fields of an event."""
