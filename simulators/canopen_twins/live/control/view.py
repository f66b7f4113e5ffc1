"""What a node is at a moment, as the control port says it; only for the thread of the twins."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from canopen_twins.device.node import Node
from canopen_twins.diagnosis.why import why
from canopen_twins.live.control.schema import ActiveFault, Emergency, NodeName, NodeState
from canopen_twins.slave.emcy import Emcy


def node_name(node: Node) -> NodeName:
    """Who it is, and whether it is there."""
    name, state = node.wire.name, str(node.state)
    return NodeName(name, node.device.title, node.node_id, state, node.powered)


def node_state(node: Node) -> NodeState:
    """Everything that is quickly told."""
    device = node.look()
    return NodeState(
        **vars(node_name(node)),
        moment=node.clock.ticks,
        booting=node.booting,
        silence=" ".join(why(node, ())),
        report=plain(device.report),
        faults=active_faults(node),
        errors=[_emergency(each) for each in device.emergencies],
        history=[_emergency(each) for each in node.log.history],
    )


def active_faults(node: Node) -> list[ActiveFault]:
    """In the order in which they came."""
    active = node.faults.active.items()
    return [
        ActiveFault(name, plain(given), node.faults.words(name, given)) for name, given in active
    ]


def _emergency(emcy: Emcy) -> Emergency:
    return Emergency(emcy.code, emcy.register, emcy.detail, emcy.label)


def plain(value: Any) -> Any:
    """A value as JSON has it; bytes are told in hex, an infinite number and what else there is by
    its text."""
    if isinstance(value, bool | int | str) or value is None:
        return value if type(value) in (bool, int, str, type(None)) else str(value)
    if isinstance(value, float):
        return value if isfinite(value) else str(value)
    if isinstance(value, bytes | bytearray):
        return value.hex(" ")
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(each) for each in value]
    return str(value)
