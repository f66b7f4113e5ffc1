"""What can go wrong with every device: on the bus between it and the master, and with its supply.

Whoever connects a device to a segment adds these to the faults that it has of its own.
"""

from collections.abc import Mapping

from canopen_twins.bus.identifiers import UNCONFIGURED
from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import Device
from canopen_twins.device.faults import Fault, Faults
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults.disturbance import AIM, FaultType, Place, fault
from canopen_twins.faults.line import LINE
from canopen_twins.faults.messages import EMCY, ERROR_CONTROL, PDO
from canopen_twins.faults.node import NODE
from canopen_twins.faults.sdo import SDO

__all__ = ["AIM", "LEVELS", "connect", "faults"]

LEVELS: Mapping[str, Mapping[str, FaultType]] = {
    "protocol": {**SDO, **PDO, **EMCY},
    "node": {**ERROR_CONTROL, **NODE},
    "line": LINE,
}


def connect(segment: Segment[Node], device: Device, name: str) -> Node:
    """Connect a device to a segment by a name of its own, with its power off.

    Raises:
        UserError: another node has this node id.
    """
    for other in segment.nodes:
        if other.device.node_id == device.node_id != UNCONFIGURED:
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
        name: fault(name, type, level, place)
        for level, types in LEVELS.items()
        for name, type in types.items()
    }
