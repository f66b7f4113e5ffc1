"""SDO: each transfer of the trace with what the device answered and what the twin does."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from canopen_twins.bus import sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address, Scs

MOST_OPEN = 4  # transfers that wait for a late answer
PATIENCE = 5_000_000  # microseconds for one
NAMING = (Scs.UPLOAD, Scs.DOWNLOAD, Scs.ABORT)
"""Answers that name their object; so do those that begin a block transfer."""


class Answer(NamedTuple):
    """What came back."""

    tick: int
    """Microseconds of the trace."""
    data: bytes
    delay: int
    """Microseconds from its request on."""


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
    rest = [each.data for each in answers[1:] if not sdo.is_abort(each.data)]
    if specifier == Scs.UPLOAD:
        told = sdo.size(first)
        form += "" if told is not None else " without its size"
        return Outcome(form, b"".join(map(sdo.segment_part, rest)), code)
    return Outcome(form, b"".join(rest) if specifier != Scs.DOWNLOAD else None, code)


class Dialogue:
    """Between a client and an SDO server of a node.

    A request that the trace has after the device's answer, while the twin still works on the one
    before, is held back until that is answered: a slow twin is told once, by its answer time.
    """

    def __init__(
        self,
        judge: Callable[[Transfer], None],
        unasked: Callable[[int, bytes], None],
        send: Callable[[Frame], None],
    ) -> None:
        self._judge = judge
        self._unasked = unasked
        self._send = send
        self._conversation = sdo.Conversation()
        self._open: deque[Transfer] = deque()
        self._asked = 0  # when, in the trace
        self._sent = 0  # when the twin was asked, in its time
        self._held: deque[tuple[Frame, Transfer]] = deque()
        self._twins: Transfer | None = None  # what the twin was asked last
        self.patience = 0
        """Microseconds that the twin may take for an answer."""

    def ask(self, tick: int, now: int, frame: Frame) -> None:
        """The client asks, at a time of the trace and one of the twin: so is the twin."""
        data = frame.data
        self._asked = tick
        whole = len(data) == sdo.LENGTH
        if whole:
            self._conversation.ask(data)
        opens = self._conversation.segment == 0 and not sdo.is_abort(data)
        if not whole or opens or not self._open:
            self._begin(tick, frame, whole and data[0] in sdo.INITIATES)
        if self._held or self._behind(now):
            self._held.append((frame, self._open[-1]))
        else:
            self._put(now, frame, self._open[-1])

    def _put(self, now: int, frame: Frame, transfer: Transfer) -> None:
        self._sent, self._twins = now, transfer
        self._send(frame)

    def _begin(self, tick: int, frame: Frame, names: bool) -> None:
        address = self._conversation.address if names else None
        self._open.append(Transfer(tick, frame, address, self._conversation.access))
        self.settle(tick)

    def _behind(self, now: int) -> bool:
        """Whether the device has answered what the twin has not yet."""
        if not self.patience or now - self._sent > self.patience:
            return False
        return any(len(each.twin) < len(each.device) for each in self._open)

    def add_device(self, tick: int, data: bytes) -> None:
        """The device has answered."""
        if (transfer := self._about(data, of_device=True)) is None:
            self._unasked(tick, data)
            return
        self._conversation.answer(data)
        transfer.device.append(Answer(tick, data, tick - self._asked))

    def add_twin(self, tick: int, now: int, data: bytes) -> None:
        """The twin has answered."""
        if (transfer := self._about(data, of_device=False)) is None:
            return
        transfer.twin.append(Answer(tick, data, now - self._sent))
        if self._held:
            self.release(now)

    def release(self, now: int) -> None:
        """Ask what was held back, as soon as the twin has answered or had its time."""
        if self._held and not self._behind(now):
            self._put(now, *self._held.popleft())

    @property
    def holds(self) -> bool:
        """Whether a request is held back."""
        return bool(self._held)

    def repeat(self, now: int) -> None:
        """Ask the twin once more what the device is about to answer."""
        if self._open:
            self._put(now, self._open[-1].request, self._open[-1])

    def _about(self, data: bytes, of_device: bool) -> Transfer | None:
        """The transfer that an answer belongs to: the last one, or one that it names."""
        last = self._open[-1] if self._open else None
        if not of_device and self._twins is not None:
            last = self._twins
        if last is None:
            return None
        if len(data) != sdo.LENGTH or sdo.specifier(data) not in NAMING:
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
