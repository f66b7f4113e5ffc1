"""What happened last on a bus, for people: the frames in words, the devices, and why."""

from collections.abc import Sequence

from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.diagnosis.expected import Expected
from canopen_twins.diagnosis.why import why

SHOWN = 20  # frames


def scene(records: Sequence[Record], nodes: Sequence[Node]) -> str:
    """The last frames of a bus, how its nodes are, and why they answered as they did."""
    reports = [device_report(node, records) for node in nodes]
    return "\n".join([last_frames(records, nodes), *reports])


def device_report(
    node: Node,
    records: Sequence[Record],
    since: float = 0.0,
    expected: Expected | None = None,
) -> str:
    """How a node is, and why it answered the last frames as it did.

    Args:
        node: As it is now.
        records: The frames of its bus, the last one last.
        since: Where their time begins, in seconds of the node's clock.
        expected: What was waited for in vain, as `why` takes it.
    """
    reasons = why(node, records[-SHOWN:], since, expected)
    return "\n".join([device_state(node), *(f"  why: {reason}" for reason in reasons)])


def last_frames(records: Sequence[Record], nodes: Sequence[Node]) -> str:
    """The last frames, each with its time, its sender and what it means."""
    decoder = Decoder(nodes)
    lines = [frame_line(record, decoder) for record in records[-SHOWN:]]
    return "\n".join(lines or ["no frame"])


def frame_line(record: Record, decoder: Decoder) -> str:
    """A frame with its time, its sender and what it means at this moment."""
    time, frame, sender = record
    return f"{time:12.6f}  {sender or '-':10}  {frame!s:21}  {decoder.words(frame)}".rstrip()


def device_state(node: Node) -> str:
    """NMT state, active faults and what a look at the model shows."""
    faults = [node.faults.words(*each) for each in node.faults.active.items()]
    lines = [
        f"{node.wire.name}: node {node.node_id}, {node.state if node.powered else 'power off'}",
        f"  faults: {', '.join(faults) or 'none'}",
        *(f"  {name}: {value}" for name, value in node.device.report.items()),
    ]
    return "\n".join(lines)
