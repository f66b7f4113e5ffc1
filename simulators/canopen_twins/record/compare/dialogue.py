"""SDO: each transfer of the trace with what the device answered and what the twin does."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from canopen_twins.bus import sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address, Scs

MOST_OPEN = 4  # transfers that wait for a late answer
PATIENCE = 5_000_000  # microseconds for one
BLOCKS = frozenset(bytes([command]) for command in sdo.BLOCK_INITIATES)
NAMING = (Scs.UPLOAD, Scs.DOWNLOAD, Scs.ABORT)
"""Answers that name their object; so do those that begin a block transfer."""


class Answer(NamedTuple):
    """What came back."""

    tick: int
    """Microseconds of the trace."""
    data: bytes
    delay: int
    """Microseconds from its request on, of the device."""


@dataclass(slots=True)
class Transfer:
    """From one initiate to the next."""

    tick: int
    request: Frame
    address: Address | None
    """Of what the request is about; none if it names nothing."""
    access: str
    device: list[Answer] = field(default_factory=list)
    twin: list[Answer] = field(default_factory=list)
    requests: int = 0
    before: bytes | None = None
    """What the twin would have answered at once, if that is something measured."""
    asked: int = 0
    """When the client has asked last."""
    until: int | None = None
    """When the next one began."""

    @property
    def in_blocks(self) -> bool:
        """Whether it has been asked for in blocks, whose segments have no answers of their own."""
        return self.request.data[:1] in BLOCKS

    @property
    def is_over(self) -> bool:
        """Whether the device has said the last word: what comes without an initiate is stray."""
        if not self.device or len(last := self.device[-1].data) != sdo.LENGTH:
            return False
        match sdo.specifier(last):
            case Scs.ABORT:
                return True
            case Scs.UPLOAD:
                return sdo.is_expedited(last)
            case Scs.DOWNLOAD:
                asked = self.request.data
                return len(asked) != sdo.LENGTH or sdo.is_expedited(asked)
        return False


class Outcome(NamedTuple):
    """What a transfer has come to, on one side."""

    form: str
    """Expedited, segmented, in blocks, written, abort or none."""
    value: bytes | None = None
    code: int | None = None


def outcome(answers: list[Answer]) -> Outcome:
    """What the answers of one side say; the first of them says which kind of transfer it is."""
    if not answers:
        return Outcome("none")
    first, aborts = answers[0].data, [each.data for each in answers if sdo.is_abort(each.data)]
    if len(first) != sdo.LENGTH:
        return Outcome(f"{len(first)} bytes long")
    if sdo.is_abort(first):
        return Outcome("abort", code=sdo.abort_code(first))
    specifier = sdo.specifier(first)
    if specifier == Scs.UPLOAD and sdo.is_expedited(first):
        size = sdo.size(first)
        return Outcome(
            "expedited" if size is not None else "expedited without its size", sdo.value(first)
        )
    form = {Scs.UPLOAD: "segmented", Scs.DOWNLOAD: "written"}.get(specifier, "in blocks")
    code = sdo.abort_code(aborts[0]) if aborts else None
    whole = [each.data for each in answers[1:] if len(each.data) == sdo.LENGTH]
    rest = [data for data in whole if not sdo.is_abort(data)]
    if specifier == Scs.UPLOAD:
        told = sdo.size(first)
        form += "" if told is not None else " without its size"
        return Outcome(form, b"".join(map(sdo.segment_part, rest)), code)
    return Outcome(form, b"".join(rest) if specifier != Scs.DOWNLOAD else None, code)


class Dialogue:
    """Between a client and an SDO server of a node.

    The twin is asked when the device answers: a request is carried out at the end of its time, and
    what the master does meanwhile comes before. How long that takes is judged by the trace alone.
    """

    def __init__(
        self,
        judge: Callable[[Transfer], None],
        unasked: Callable[[int, bytes], None],
        send: Callable[[Frame], None],
        look: Callable[[Address], bytes | None],
        patience: int,
    ) -> None:
        """`look` is at something measured. `patience` is in microseconds.

        After that time the twin is asked, though the device is silent.
        """
        self._look = look
        self._judge = judge
        self._unasked = unasked
        self._send = send
        self._patience = patience
        self._conversation = sdo.Conversation()
        self._open: deque[Transfer] = deque()
        self._waiting: Frame | None = None
        self._twins: Transfer | None = None  # what the twin was asked last

    def ask(self, tick: int, frame: Frame) -> None:
        """The client asks, at a time of the trace."""
        self._put()
        data = frame.data
        whole = len(data) == sdo.LENGTH
        if whole:
            self._conversation.ask(data)
        opens = self._conversation.segment == 0 and not sdo.is_abort(data)
        if not whole or opens or not self._open or self._open[-1].is_over:
            self._begin(tick, frame, whole and opens)
        self._open[-1].asked = tick
        self._open[-1].requests += 1
        self._waiting = frame
        if sdo.is_abort(data):
            self._put()

    def _begin(self, tick: int, frame: Frame, names: bool) -> None:
        if self._open:
            self._open[-1].until = tick
        address = self._conversation.address if names else None
        transfer = Transfer(tick, frame, address, self._conversation.access)
        if address is not None and transfer.access == sdo.READ:
            transfer.before = self._look(address)
        self._open.append(transfer)
        self.settle(tick)

    def _put(self) -> None:
        """Let the twin have what waits."""
        if self._waiting is not None:
            frame, self._waiting = self._waiting, None
            self._twins = self._open[-1]
            self._send(frame)

    @property
    def due(self) -> float:
        """When the twin is asked, though the device is silent; infinite if nothing waits."""
        return inf if self._waiting is None else self._open[-1].asked + self._patience

    def hurry(self, tick: int) -> None:
        """Let the twin have the request if the device takes too long."""
        if tick >= self.due:
            self._put()

    def add_device(self, tick: int, data: bytes) -> None:
        """The device has answered."""
        self._put()
        transfer = self._about(data, of_device=True)
        if transfer is None or self._names_another(transfer, tick, data):
            if self._twins is not None:  # its request is not older than the trace
                self._unasked(tick, data)
            return
        self._conversation.answer(data)
        transfer.device.append(Answer(tick, data, tick - transfer.asked))

    def _names_another(self, transfer: Transfer, tick: int, data: bytes) -> bool:
        """Whether it is the answer to a request that the trace lacks, and too late for this one."""
        if len(data) != sdo.LENGTH or sdo.specifier(data) not in NAMING or not any(data[1:4]):
            return False
        late = tick - transfer.asked > self._patience
        another = transfer.address is not None and sdo.address(data) != transfer.address
        return late and (another or transfer.is_over)

    def recover(self, tick: int, request: Frame, data: bytes) -> None:
        """The device has answered a request that the trace lacks: let the twin have it."""
        self.ask(tick, request)
        self._put()
        self._open[-1].device.append(Answer(tick, data, 0))

    def add_twin(self, tick: int, data: bytes) -> None:
        """The twin has answered."""
        if (transfer := self._about(data, of_device=False)) is not None:
            transfer.twin.append(Answer(tick, data, 0))

    def _about(self, data: bytes, of_device: bool) -> Transfer | None:
        """The transfer that an answer belongs to: the last one, or one that it names."""
        last = self._open[-1] if of_device and self._open else self._twins
        if last is None or len(data) != sdo.LENGTH or sdo.specifier(data) not in NAMING:
            return last
        told = sdo.address(data)
        if last.address in (None, told) or (sdo.is_abort(data) and not any(data[1:4])):
            return last
        for transfer in self._open:
            if transfer.address == told and not (transfer.device if of_device else transfer.twin):
                return transfer
        return None if of_device and last.device else last

    def settle(self, tick: float) -> None:
        """Judge what is over: answered on both sides, or too old for an answer."""
        while len(self._open) > 1:
            first = self._open[0]
            answered = bool(first.device and first.twin)
            if not answered and len(self._open) <= MOST_OPEN and tick - first.tick < PATIENCE:
                return
            self._judge(self._open.popleft())

    def end(self, tick: int) -> None:
        """Judge all that there is; a request after `tick` had no time to be answered."""
        while self._open:
            transfer = self._open.popleft()
            if transfer.device or transfer.tick <= tick:
                self._judge(transfer)
