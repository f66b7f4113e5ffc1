"""Why a device answered as it did, in words with the section of its manual.

What follows from the node as it is (power, dictionary, settings, faults) is worked out when
somebody asks; what does not, the event log of its wire has kept.
"""

from collections.abc import Sequence

from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.expected import missing, silence, sought
from canopen_twins.diagnosis.frames import commands, emergencies, pdos, requests
from canopen_twins.diagnosis.sections import Sections, sections
from canopen_twins.diagnosis.view import View
from canopen_twins.slave.object import Address

__all__ = ["TOLD", "Sections", "sections", "why"]

TOLD = 6  # lines about frames


def why(
    node: Node,
    records: Sequence[Record],
    since: float = 0.0,
    wanted: str = "",
    about: Sequence[Address] = (),
) -> list[str]:
    """What stood between a master and a node lately, the last of it last.

    Args:
        node: The one that is asked about, as it is now.
        records: The last frames of the bus.
        since: Where the time of the records begins, in seconds of the node's clock.
        wanted: What was waited for in vain, in words as a scenario has them: they begin with a
            frame in the notation of cansend, with `EMCY`, `heartbeat`, `state`, `write`, `NMT` or
            with `no frame`; empty if nothing was.
        about: The objects it is about.
    """
    view = View(node, records, since)
    explain = (requests, pdos, commands, emergencies)
    places = {id(record): place for place, record in enumerate(records)}
    lines = [line for lines in explain for line in lines(view)]
    lines.sort(key=lambda line: places[id(line.record)])
    told = [line.text for line in lines[-TOLD:]]
    told += filter(None, (silence(view), missing(view, wanted)))
    return [*told, *sought(view, wanted, about, "\n".join(told))]
