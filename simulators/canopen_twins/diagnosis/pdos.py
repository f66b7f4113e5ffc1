"""PDOs that a node did not take, or did not send when asked for."""

from collections.abc import Iterable, Iterator
from math import inf

from canopen_twins.bus.segment import Record
from canopen_twins.diagnosis.view import Line, View
from canopen_twins.slave import cob_id as cob_ids
from canopen_twins.slave.pdo import COB_ID, Pdo, carried
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo


def explained(view: View) -> Iterator[Line]:
    """A line for every RPDO that was not taken and every TPDO that was asked for in vain."""
    slave = view.node.slave
    if slave is None:
        return
    for kind, why in ((Rpdo, _not_taken), (Tpdo, _not_sent)):
        for number in kind.numbers(slave):
            name = f"{kind.__name__.upper()}{number}"
            for record, until in _foreign(view, kind, _cob_id(slave, kind, number)):
                text = _off(view, slave, kind, number, record)
                text = text or why(view, slave, number, record, until)
                if text:
                    yield Line(record, f"{record.frame} {name} {text}")


def _foreign(view: View, kind: type[Pdo], cob_id: int) -> Iterable[tuple[Record, float]]:
    """What the node heard with this identifier, each with the time of the next one."""
    wanted = (cob_id & cob_ids.CAN_ID, kind.sent)
    heard = [record for record in view.records if not view.is_own(record)]
    heard = [each for each in heard if (each.frame.can_id, each.frame.remote) == wanted]
    times = [*(record.time for record in heard[1:]), inf]
    return zip(heard, times, strict=False)


def _cob_id(slave: Slave, kind: type[Pdo], number: int) -> int:
    return slave.number(kind.communication + number - 1, COB_ID)


def _off(view: View, slave: Slave, kind: type[Pdo], number: int, record: Record) -> str:
    """What keeps a PDO from existing, whichever direction it has."""
    verb = "not sent" if kind.sent else "not taken"
    if not view.may(record.time, kind.active_in):
        return f"{verb}: {view.unable(record.time, kind.active_in, 'PDO')}"
    if _cob_id(slave, kind, number) & cob_ids.INVALID:
        where = view.named((kind.communication + number - 1, COB_ID))
        return f"{verb}: it is off, bit 31 of {where} is set"
    for note in view.strikes():
        if note.between(record.time, record.time) and note.about == str(record.frame):
            return f"{verb}: the fault {note.fault}"
    return ""


def _not_sent(view: View, slave: Slave, number: int, record: Record, until: float) -> str:
    """A remote request may be forbidden, or find nothing that is mapped."""
    if _cob_id(slave, Tpdo, number) & cob_ids.NO_RTR:
        return f"not sent: bit 30 of {view.named((Tpdo.communication + number - 1, COB_ID))} is set"
    if not carried(slave, Tpdo.mapping + number - 1):
        return f"not sent: nothing is mapped in {view.named((Tpdo.mapping + number - 1, 0))}"
    return ""


def _not_taken(view: View, slave: Slave, number: int, record: Record, until: float) -> str:
    """Data may be too few, refused by an object, or of no use at this moment."""
    parts, data = carried(slave, Rpdo.mapping + number - 1), record.frame.data
    length = sum(each.size for each in parts)
    if len(data) < length:
        return f"not taken: {len(data)} of {length} bytes{view.service('pdo')}"
    note = view.refusal(record.frame, record.time, until)
    if note is not None and note.address is not None:
        return f"refused: {note.words}, {view.named(note.address)}"
    for entry, _, part in parts:
        acts = None if entry is None else entry.obstacle
        if entry is not None and acts is not None and (obstacle := acts(entry.unpack(data[part]))):
            return f"without effect: {obstacle}, {view.named(entry.address)}"
    return ""
