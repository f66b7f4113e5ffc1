"""Why a device answered as it did, in words with the section of its manual.

What follows from the node as it is (power, dictionary, settings, faults) is worked out when
somebody asks; what does not, the event log of its wire has kept.
"""

from collections.abc import Sequence

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import sdo_request
from canopen_twins.bus.sdo import is_answer
from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.expected import Expected
from canopen_twins.diagnosis.frames import commands, emergencies, pdos, requests
from canopen_twins.diagnosis.sections import Sections, sections
from canopen_twins.diagnosis.view import Line, View
from canopen_twins.errors import UserError

__all__ = ["TOLD", "Sections", "sections", "why", "why_frame"]

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
    lines = _lines(view)
    told = [line.text for line in lines[-TOLD:]]
    if silent := _silence(node, view):
        told.append(silent)
    if expected is not None and node.slave is not None:
        told += expected.reasons(view, node.slave, "\n".join(told))
    return told


def why_frame(node: Node, records: Sequence[Record], frame: Frame) -> list[str]:
    """What was out of the ordinary with a frame; of an SDO answer also with what it answers.

    Args:
        node: The one that is asked about, as it is now.
        records: The last frames of the bus; the last one like this is meant.
        frame: As it was on the bus.

    Raises:
        UserError: there is no such frame among the records.
    """
    places = [place for place, record in enumerate(records) if record.frame == frame]
    if not places:
        raise UserError(f"{frame} is not among the last {len(records)} frames")
    view = View(node, records[: places[-1] + 1])
    about = [records[places[-1]]]
    if is_answer(frame, view.node_id):
        request = sdo_request(view.node_id)
        about += [each for each in view.records if each.frame.can_id == request][-1:]
    return [line.text for line in _lines(view) if any(line.record is each for each in about)]


def _lines(view: View) -> list[Line]:
    """All that was out of the ordinary, in the order of the frames it is about."""
    explain = (requests, pdos, commands, emergencies)
    places = {id(record): place for place, record in enumerate(view.records)}
    lines = [line for lines in explain for line in lines(view)]
    lines.sort(key=lambda line: places[id(line.record)])
    return lines


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
