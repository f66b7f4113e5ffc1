"""Why a device answered as it did, in words with the section of its manual.

What follows from the node as it is (power, dictionary, settings, faults) is worked out when
somebody asks; what does not, the event log of its wire has kept.
"""

from collections.abc import Sequence

from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.expected import Expected
from canopen_twins.diagnosis.frames import commands, emergencies, pdos, requests
from canopen_twins.diagnosis.sections import Sections, sections
from canopen_twins.diagnosis.view import View

__all__ = ["TOLD", "Sections", "sections", "why"]

TOLD = 6  # lines about frames


def why(
    node: Node,
    records: Sequence[Record],
    since: float = 0.0,
    expected: Expected | None = None,
) -> list[str]:
    """What stood between a master and a node lately, the last of it last.

    Args:
        node: The one that is asked about, as it is now.
        records: The last frames of the bus.
        since: Where the time of the records begins, in seconds of the node's clock.
        expected: What was waited for in vain, such as `ExpectedFrame(0x185)`: one of those of
            `diagnosis.expected`. Nothing is known of it while the node is silent.
    """
    view = View(node, records, since)
    explain = (requests, pdos, commands, emergencies)
    places = {id(record): place for place, record in enumerate(records)}
    lines = [line for lines in explain for line in lines(view)]
    lines.sort(key=lambda line: places[id(line.record)])
    told = [line.text for line in lines[-TOLD:]]
    if silent := _silence(node, view):
        told.append(silent)
    if expected is not None and node.slave is not None:
        told += expected.reasons(view, node.slave, "\n".join(told))
    return told


def _silence(node: Node, view: View) -> str:
    """Why the node is not on the bus; empty if it is."""
    if not node.powered:
        return "the node is silent: its supply is off"
    if node.slave is None:
        time = f"{node.device.timing.boot_time:g} s (boot_time)"
        booting = f"it boots, which takes {time}" if node.booting else "it has not booted"
        reason = node.device.silence or booting
        return f"the node is silent: {reason}{view.service('silence')}"
    if node.wire.cut_off:
        return f"the node neither hears nor is heard: {node.wire.cut_off}{view.service('silence')}"
    if node.slave.shut:
        reason = node.device.silence or "it has shut itself off for a while"
        return f"the node is off the bus: {reason}{view.service('silence')}"
    return ""
