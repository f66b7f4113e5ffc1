"""What can go wrong with every device: on the bus between it and the master, and with its supply.

A segment adds these to the faults that a device has of its own.
"""

from collections.abc import Mapping

from simulators.faults import Fault, Faults
from simulators.mischief.disturbance import Kind, Place, fault
from simulators.mischief.emcy import EMCY
from simulators.mischief.line import LINE
from simulators.mischief.node_faults import NODE
from simulators.mischief.pdo import PDO
from simulators.mischief.sdo import SDO
from simulators.mischief.turn import AIM
from simulators.node import Node

__all__ = ["AIM", "LEVELS", "faults"]

LEVELS: Mapping[str, Mapping[str, Kind]] = {
    "protocol": {**SDO, **PDO, **EMCY},
    "node": NODE,
    "line": LINE,
}


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
