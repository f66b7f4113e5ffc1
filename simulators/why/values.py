"""What stands in the way of the values of objects, and how else a master could write them."""

from collections.abc import Iterator, Sequence

from simulators.entry import Entry
from simulators.objects import Address, Rejected
from simulators.services import cob_id as cob_ids
from simulators.services.mapping import mapped
from simulators.services.pdo import COB_ID
from simulators.services.rpdo import Rpdo
from simulators.slave import Slave
from simulators.why.view import View


def values(view: View, slave: Slave, about: Sequence[Address], told: str) -> Iterator[str]:
    """What keeps a device from doing as its objects tell it, and where they are explained."""
    errors = [f"{each.code:04X}h {each.label}".strip() for each in view.node.log.active]
    if news := [each for each in errors if each.partition(" ")[2] not in told]:
        yield f"active: {', '.join(news)}"
    for obstacle, names in _obstacles(view, slave, about).items():
        if obstacle not in told:
            yield f"without effect now: {obstacle}, {', '.join(names)}"
    if sources := [view.named(each) for each in about if view.sections.object(each)]:
        yield f"see {', '.join(sources)}"


def _obstacles(view: View, slave: Slave, about: Sequence[Address]) -> dict[str, list[str]]:
    """The objects in whose way each of them stands."""
    obstacles: dict[str, list[str]] = {}
    for entries in slave.entries.values():
        for entry in entries.values():
            if obstacle := _obstacle(entry, about):
                obstacles.setdefault(obstacle, []).append(view.named(entry.address))
    return obstacles


def _obstacle(entry: Entry, about: Sequence[Address]) -> str:
    """In the way of the value that an object has; of one that nobody has set, only if asked."""
    if entry.obstacle is None:
        return ""
    try:
        data = entry.read()
    except Rejected:
        return ""
    told = data != entry.initial or entry.address in about
    return entry.obstacle(entry.unpack(data)) if told else ""


def ways(view: View, slave: Slave, about: Sequence[Address]) -> Iterator[str]:
    """How a master could have written objects, other than by SDO."""
    for number in Rpdo.numbers(slave):
        for entry in _mapped(slave, number):
            if entry.address in about:
                record = Rpdo.communication + number - 1
                cob_id = slave.number(record, COB_ID)
                off = f", which is off: bit 31 of {view.named((record, COB_ID))} is set"
                way = f"RPDO{number}, {cob_id & cob_ids.CAN_ID:03X}h"
                yield f"{view.named(entry.address)} is in {way}" + (
                    off if cob_id & cob_ids.INVALID else ""
                )


def _mapped(slave: Slave, number: int) -> Iterator[Entry]:
    try:
        parts = mapped(slave, Rpdo.mapping + number - 1)
    except Rejected:
        return
    yield from (entry for entry, _ in parts if isinstance(entry, Entry))
