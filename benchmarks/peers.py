"""What the twins are measured against: canopen's `LocalNode`, as shipped, with the same EDS."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import canopen

from canopen_twins.files.shipped import od_file

NODE_ID = 5
ACTUAL_VOLTAGE = 0x2020
EXAMPLES = Path(__file__).parent.parent / "docs" / "examples"
FAN = EXAMPLES / "canopen-fan" / "canopen_fan" / "fan.eds"


class Mute:
    """A bus that takes every message and does nothing with it."""

    channel_info = "nowhere"

    def send(self, message: Any, timeout: float | None = None) -> None:
        """Take it."""


def local_node() -> canopen.LocalNode:
    """A node with the objects of a TopCon; a process value needs something to be read."""
    with od_file("topcon.eds") as path:
        node = canopen.LocalNode(NODE_ID, str(path))
    node.set_data(ACTUAL_VOLTAGE, 0, bytes(2))
    return node


def muted() -> canopen.Network:
    """A network with that node, to be notified of frames by hand."""
    bus: Any = Mute()
    network = canopen.Network(bus)
    network.add_node(local_node())
    return network


@contextmanager
def master(channel: str, eds: str | Path = "topcon.eds") -> Iterator[canopen.RemoteNode]:
    """A master's view of the node from the other end of a `virtual` bus."""
    network = canopen.Network().connect(interface="virtual", channel=channel)
    with network, od_file(str(eds)) as path:
        yield network.add_node(NODE_ID, str(path))


@contextmanager
def virtual(channel: str, eds: Path | None = None) -> Iterator[canopen.RemoteNode]:
    """The same, with the `LocalNode` on the bus, that of a file if it is given."""
    network = canopen.Network().connect(interface="virtual", channel=channel)
    network.add_node(canopen.LocalNode(NODE_ID, str(eds)) if eds else local_node())
    with network, master(channel, eds or "topcon.eds") as remote:
        yield remote
