"""Why a node did not obey what it heard, request by request, and what its emergencies are about."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from math import inf

from canopen import SdoAbortedError

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Ccs
from canopen_twins.bus.segment import Record
from canopen_twins.diagnosis.view import Line, Strike, View, in_brackets
from canopen_twins.slave.emcy import Emcy, emcy_id, emcy_of
from canopen_twins.slave.nmt import ALL_NODES, RESETS, TARGET, Nmt
from canopen_twins.slave.object import Address, Rejected
from canopen_twins.slave.pdo import COB_ID, Pdo, Rpdo, Tpdo, carried
from canopen_twins.slave.sdo_server import SdoServer
from canopen_twins.slave.slave import Slave

MULTIPLEXER = slice(6, 12)  # of the text of a frame


@dataclass
class Request:
    """One request with what came back before the next one."""

    record: Record
    address: Address | None
    opens: bool
    """Whether it is no segment: those of a block have no answer of their own."""
    until: float = inf
    """Seconds at which the next one came."""
    answers: list[Record] = field(default_factory=list)

    @property
    def frame(self) -> Frame:
        """As it was sent."""
        return self.record.frame

    @property
    def refusal(self) -> Record | None:
        """The abort among its answers."""
        return next((each for each in self.answers if sdo.is_abort(each.frame.data)), None)


def _requests(view: View) -> Iterator[Request]:
    """The requests to the node, in their order."""
    conversation, last = sdo.Conversation(), None
    for record in view.records:
        frame = record.frame
        asks = frame.can_id == identifiers.sdo_request(view.node_id) and not frame.remote
        if asks and not view.is_own(record):
            if last is not None:
                last.until = record.time
                yield last
            if len(frame.data) == sdo.LENGTH:
                conversation.ask(frame.data)
            opens = conversation.segment == 0 and not sdo.is_abort(frame.data)
            last = Request(record, conversation.address, opens)
        elif last is not None and view.is_own(record) and sdo.is_answer(frame, view.node_id):
            last.answers.append(record)
            conversation.answer(frame.data)
    if last is not None:
        yield last


def requests(view: View) -> Iterator[Line]:
    """A line for every request that was refused, not answered, or struck by a fault."""
    asked, struck = list(_requests(view)), view.strikes()
    opening = [request for request in asked if request.opens]
    writes = {each.address: each for each in opening if _is_expedited_write(each.frame.data)}
    for request in asked:
        text = _struck(view, request, struck) or _refused(view, request)
        text = text or _unanswered(view, request)
        if not text and writes.get(request.address) is request:
            text = _without_effect(view, request)
        if text:
            yield Line(request.record, f"{request.frame} {text}")


def _is_expedited_write(data: bytes) -> bool:
    return bool(data) and sdo.specifier(data) == Ccs.DOWNLOAD and sdo.is_expedited(data)


def _struck(view: View, request: Request, struck: list[Strike]) -> str:
    """The fault that struck it or its answer, which is out of the list then."""
    answer = f"{identifiers.sdo_answer(view.node_id):03X}#"
    told = str(request.frame)
    for strike in [each for each in struck if each.between(request.record.time, request.until)]:
        same_object = strike.about[MULTIPLEXER] == told[MULTIPLEXER]
        if strike.about == told or (strike.about.startswith(answer) and same_object):
            struck.remove(strike)
            verb = "refused" if request.refusal else "answered"
            return f"{verb if request.answers else 'not answered'}: the fault {strike.fault}"
    return ""


def _refused(view: View, request: Request) -> str:
    if (answer := request.refusal) is None:
        return ""
    code, address = sdo.abort_code(answer.frame.data), sdo.address(answer.frame.data)
    logged = view.refusal(answer.frame, request.record.time, answer.time)
    usual = SdoAbortedError.CODES.get(code, f"abort code {code:08X}h")
    about = f", {view.named(address)}" if any(address) else view.service("sdo")
    return f"refused: {logged.words if logged else usual}{about}"


def _unanswered(view: View, request: Request) -> str:
    if request.answers or not request.opens:
        return ""
    if len(request.frame.data) != sdo.LENGTH:
        length = f"a request has {sdo.LENGTH} bytes, not {len(request.frame.data)}"
        return f"not answered: {length}{view.service('sdo')}"
    time = request.record.time
    if logged := view.refusal(request.frame, time, request.until):
        return f"not answered: {logged.words}{view.service('sdo')}"
    unable = view.unable(time, SdoServer.active_in, "SDO")
    return f"not answered: {unable}" if unable else ""


def _without_effect(view: View, request: Request) -> str:
    """Of an expedited download that was accepted: what stands in its way now."""
    slave = view.node.slave
    if slave is None or request.address is None or not request.answers:
        return ""
    try:
        entry = slave.entry(*request.address)
    except Rejected:
        return ""
    if entry.obstacle is None or entry.size is None or entry.size > sdo.EXPEDITED_ROOM:
        return ""
    if obstacle := entry.obstacle(entry.unpack(request.frame.data[4 : 4 + entry.size])):
        return f"accepted, without effect now: {obstacle}, {view.named(request.address)}"
    return ""


def pdos(view: View) -> Iterator[Line]:
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
    wanted = (cob_id & identifiers.CAN_ID, kind.sent)
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
    if _cob_id(slave, kind, number) & identifiers.INVALID:
        where = view.named((kind.communication + number - 1, COB_ID))
        return f"{verb}: it is off, bit 31 of {where} is set"
    for strike in view.strikes():
        if strike.between(record.time, record.time) and strike.about == str(record.frame):
            return f"{verb}: the fault {strike.fault}"
    return ""


def _not_sent(view: View, slave: Slave, number: int, record: Record, until: float) -> str:
    """A remote request may be forbidden, or find nothing that is mapped."""
    if _cob_id(slave, Tpdo, number) & identifiers.NO_RTR:
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
    logged = view.refusal(record.frame, record.time, until)
    if logged is not None and logged.address is not None:
        return f"refused: {logged.words}, {view.named(logged.address)}"
    for entry, _, part in parts:
        acts = None if entry is None else entry.obstacle
        if entry is not None and acts is not None and (obstacle := acts(entry.unpack(data[part]))):
            return f"without effect: {obstacle}, {view.named(entry.address)}"
    return ""


def emergencies(view: View) -> Iterator[Line]:
    """What every emergency of the node is about; the end of an error needs no reason."""
    slave = view.node.slave
    can_id = None if slave is None else emcy_id(slave)
    for record in view.records:
        is_emcy = view.is_own(record) and record.frame.can_id == can_id
        if is_emcy and (text := _emergency(view, record.frame.data)):
            yield Line(record, text)


def _emergency(view: View, data: bytes) -> str:
    told = emcy_of(data)
    meaning = _meaning(view, told) if told.code else ""
    return f"EMCY {told.code:04X}h detail {told.detail:X}h: {meaning}" if meaning else ""


def _meaning(view: View, told: Emcy) -> str:
    """Its label and its section; empty if nobody knows it."""
    known = [*view.node.device.emergencies, *view.node.log.history]
    label = next((emcy.label for emcy in known if told.is_like(emcy)), "")
    return f"{label}{in_brackets(view.sections.emcy(told.code))}".strip()


def commands(view: View) -> Iterator[Line]:
    """NMT commands that had no effect, and why."""
    for record in view.records:
        is_nmt = record.frame.can_id == identifiers.NMT and not record.frame.remote
        if is_nmt and (text := _command(view, record.frame, record.time)):
            yield Line(record, f"{record.frame} not obeyed: {text}")


def _command(view: View, frame: Frame, time: float) -> str:
    if len(frame.data) not in view.node.device.profile.nmt_lengths:
        return f"an NMT command has 2 bytes, not {len(frame.data)}{view.service('nmt')}"
    command, target = frame.data[:2]
    if target not in (ALL_NODES, view.node_id):
        return ""
    if command not in {*TARGET, *RESETS}:
        return f"there is no command {command:02X}h{view.service('nmt')}"
    return "" if view.may(time, Nmt.active_in) else view.unable(time, Nmt.active_in, "NMT")
