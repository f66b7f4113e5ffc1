"""What can go wrong with every device: on the bus between it and the master, and with its supply.

Whoever connects a device to a segment adds these to the faults that it has of its own.
"""

from collections.abc import Mapping

from simulators.device import Device
from simulators.errors import UserError
from simulators.faults import Fault, Faults
from simulators.mischief.disturbance import Kind, Place, fault
from simulators.mischief.emcy import EMCY
from simulators.mischief.line import LINE
from simulators.mischief.node_faults import NODE
from simulators.mischief.pdo import PDO
from simulators.mischief.sdo import SDO
from simulators.mischief.turn import AIM
from simulators.node import Node
from simulators.segment import Segment

__all__ = ["AIM", "LEVELS", "connect", "faults"]

LEVELS: Mapping[str, Mapping[str, Kind]] = {
    "protocol": {**SDO, **PDO, **EMCY},
    "node": NODE,
    "line": LINE,
}


def connect(segment: Segment[Node], device: Device, name: str) -> Node:
    """Connect a device to a segment by a name of its own, with its power off.

    Raises:
        UserError: another node has this node id.
    """
    for other in segment.nodes:
        if other.device.node_id == device.node_id:
            raise UserError(f"two nodes with node id {device.node_id} on one bus")
    node = Node(device, segment.clock, segment.outbox, name)
    node.faults = faults(node, segment.nodes)
    segment.nodes.append(node)
    return node


def faults(node: Node, nodes: list[Node]) -> Faults:
    """The faults of the device of a node, and those around it.

    Raises:
        ValueError: the device has one of a name that stands for one of these.
    """
    return Faults(node.device.faults, _around(Place(node, nodes)))


def _around(place: Place) -> Mapping[str, Fault]:
    return {
        name: fault(name, kind, level, place)
        for level, kinds in LEVELS.items()
        for name, kind in kinds.items()
    }
