"""SDO requests: which answer belongs to which, why it refuses, and why there is none."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf

from canopen import SdoAbortedError

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record
from canopen_twins.diagnosis.view import Line, Strike, View
from canopen_twins.faults.sdo import Conversation, is_answer
from canopen_twins.slave.object import Address, Rejected
from canopen_twins.slave.sdo.server import (
    DOWNLOADS,
    EXPEDITED,
    EXPEDITED_ROOM,
    REQUEST_LENGTH,
    SdoServer,
)

ABORT = 0x80  # of the client and of the server; a block has no segment 0
EXPEDITED_WRITES = {bytes([command]) for command in DOWNLOADS if command & EXPEDITED}
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
        return next((each for each in self.answers if each.frame.data[0] == ABORT), None)


def requests(view: View) -> Iterator[Request]:
    """The requests to the node, in their order."""
    conversation, last = Conversation(), None
    for record in view.records:
        frame = record.frame
        if frame.can_id == 0x600 + view.node_id and not (frame.remote or view.is_own(record)):
            if last is not None:
                last.until = record.time
                yield last
            if len(frame.data) == REQUEST_LENGTH:
                conversation.ask(frame.data)
            opens = conversation.segment == 0 and frame.data[:1] != bytes([ABORT])
            last = Request(record, conversation.address, opens)
        elif last is not None and view.is_own(record) and is_answer(view.node, frame):
            last.answers.append(record)
            conversation.answer(frame.data)
    if last is not None:
        yield last


def explained(view: View) -> Iterator[Line]:
    """A line for every request that was refused, not answered, or struck by a fault."""
    asked, struck = list(requests(view)), view.strikes()
    opening = [request for request in asked if request.opens]
    writes = {each.address: each for each in opening if each.frame.data[:1] in EXPEDITED_WRITES}
    for request in asked:
        text = _struck(view, request, struck) or _refused(view, request)
        text = text or _unanswered(view, request)
        if not text and writes.get(request.address) is request:
            text = _without_effect(view, request)
        if text:
            yield Line(request.record, f"{request.frame} {text}")


def _struck(view: View, request: Request, struck: list[Strike]) -> str:
    """The fault that struck it or its answer, which is out of the list then."""
    answer = f"{0x580 + view.node_id:03X}#"
    told = str(request.frame)
    for note in (each for each in struck if each.between(request.record.time, request.until)):
        its_answer = note.about.startswith(answer) and note.about[MULTIPLEXER] == told[MULTIPLEXER]
        if note.about == told or its_answer:
            struck.remove(note)
            verb = "refused" if request.refusal else "answered"
            return f"{verb if request.answers else 'not answered'}: the fault {note.fault}"
    return ""


def _refused(view: View, request: Request) -> str:
    if (answer := request.refusal) is None:
        return ""
    data = answer.frame.data
    code, address = int.from_bytes(data[4:8], "little"), (data[1] | data[2] << 8, data[3])
    note = view.refusal(answer.frame, request.record.time, answer.time)
    usual = SdoAbortedError.CODES.get(code, f"abort code {code:08X}h")
    about = f", {view.named(address)}" if any(address) else view.service("sdo")
    return f"refused: {note.words if note else usual}{about}"


def _unanswered(view: View, request: Request) -> str:
    if request.answers or not request.opens:
        return ""
    if len(request.frame.data) != REQUEST_LENGTH:
        length = f"a request has {REQUEST_LENGTH} bytes, not {len(request.frame.data)}"
        return f"not answered: {length}{view.service('sdo')}"
    unable = view.unable(request.record.time, SdoServer.active_in, "SDO")
    return f"not answered: {unable}" if unable else ""


def _without_effect(view: View, request: Request) -> str:
    """Of an expedited download that was accepted: what stands in its way now."""
    slave, data = view.node.slave, request.frame.data
    if slave is None or request.address is None or not request.answers:
        return ""
    try:
        entry = slave.entry(*request.address)
    except Rejected:
        return ""
    if entry.obstacle is None or entry.size is None or entry.size > EXPEDITED_ROOM:
        return ""
    if obstacle := entry.obstacle(entry.unpack(data[4 : 4 + entry.size])):
        return f"accepted, without effect now: {obstacle}, {view.named(request.address)}"
    return ""
