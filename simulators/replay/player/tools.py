"""What every step of a run works with."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from simulators.clock import Clock
from simulators.frame import Frame
from simulators.node import Node
from simulators.replay.player.client import Client
from simulators.replay.player.happenings import Happenings
from simulators.replay.player.healing import Healing
from simulators.replay.player.judge import Judge


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
