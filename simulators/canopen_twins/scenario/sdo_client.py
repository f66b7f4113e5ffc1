"""The scenario's own master: what it sends, and its SDO clients, one transfer after the other."""

from collections import deque
from collections.abc import Callable, Generator, Mapping
from functools import partial
from typing import NamedTuple

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import Clock, Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address, Ccs, Scs
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.slave.object import Abort

ACCEPTED = 0


class Answer(NamedTuple):
    """What came of a transfer."""

    code: int | None
    """`ACCEPTED`, the abort code, or None if there was no answer in time."""
    data: bytes = b""
    """What has been read."""
    by_client: bool = False
    """Whether it was the client that had to abort, as the answer was none to its request."""


UNANSWERED = Answer(None)


Transfer = Generator[bytes, bytes, Answer]
"""Gives requests, takes their answers, and returns what came of it."""


def download(address: Address, data: bytes, sized: bool = True) -> Transfer:
    """Write; what fits goes in one frame, and without `sized` it leaves open how many bytes count.

    More than four bytes go in segments.
    """
    named = sdo.multiplexer(address)
    if len(data) <= sdo.EXPEDITED_ROOM:
        answer = yield sdo.expedited(Ccs.DOWNLOAD, named, data, sized)
        return _result(answer, Scs.DOWNLOAD)
    answer = yield sdo.announcing(Ccs.DOWNLOAD, named, len(data))
    result = _result(answer, Scs.DOWNLOAD)
    for segment in sdo.segments(data):
        if result.code == ACCEPTED:
            answer = yield segment
            result = _result(answer, Scs.DOWNLOAD_SEGMENT, segment[0] & sdo.TOGGLE)
    return result


def upload(address: Address) -> Transfer:
    """Read, in one frame or in segments as the server wants it."""
    answer = yield sdo.message(Ccs.UPLOAD, sdo.multiplexer(address))
    if sdo.specifier(answer) != Scs.UPLOAD:
        return _result(answer, Scs.UPLOAD)
    if sdo.is_expedited(answer):
        return Answer(ACCEPTED, sdo.value(answer))
    data, toggle = b"", 0
    while True:
        answer = yield sdo.message(Ccs.UPLOAD_SEGMENT, flags=toggle)
        if sdo.specifier(answer) != Scs.UPLOAD_SEGMENT or answer[0] & sdo.TOGGLE != toggle:
            return _result(answer, Scs.UPLOAD_SEGMENT, toggle)
        data += sdo.segment_part(answer)
        if answer[0] & sdo.LAST:
            return Answer(ACCEPTED, data)
        toggle ^= sdo.TOGGLE


def _result(answer: bytes, specifier: int, flags: int = 0) -> Answer:
    expected = specifier << 5 | flags
    if sdo.is_abort(answer):
        return Answer(sdo.abort_code(answer))
    if answer[0] == expected:
        return Answer(ACCEPTED)
    wrong_toggle = answer[0] ^ expected == sdo.TOGGLE
    return Answer(Abort.TOGGLE if wrong_toggle else Abort.COMMAND, by_client=True)


Talk = Generator[bytes, bytes | None, None]
"""The transfers of one step; takes None where there was no answer in time."""


class SdoClient:
    """Asks one node; what is answered at once goes on at once, before anybody else acts.

    `send` puts a frame on the bus and brings it to everybody, if frames take no time there.
    """

    def __init__(self, node: Node, clock: Clock, send: Callable[[Frame], None]) -> None:
        self._node = node
        self._clock = clock
        self._send = send
        self._talks: deque[Talk] = deque()
        self._talk: Talk | None = None
        self._request: bytes | None = None
        self._answer: bytes | None = None
        self._server = 0
        self._patience = 0.0
        self._timer: Timer | None = None

    def ask(self, talk: Talk) -> None:
        """Make transfers after those that are to be made already."""
        self._talks.append(talk)
        if self._talk is None:
            self._go_on(None)

    def make(self, transfer: Transfer, patience: float) -> Generator[bytes, bytes | None, Answer]:
        """One transfer of a talk, whose answers have to come within so many seconds each.

        The client aborts what goes wrong on its side (CiA 301, 7.2.4.3.17).
        """
        self._patience = patience
        request = next(transfer)
        named = request[1:4]
        try:
            while True:
                answer = yield request
                if answer is None:
                    self._say(sdo.abort(named, Abort.TIME_OUT))
                    return UNANSWERED
                request = transfer.send(answer)
        except StopIteration as end:
            result: Answer = end.value
        if result.by_client:
            self._say(sdo.abort(named, result.code or ACCEPTED))
        return result

    def hear(self, frame: Frame) -> None:
        """Take a frame from the bus."""
        request, data = self._request, frame.data
        if request is None or frame.can_id != self._server or len(data) != sdo.LENGTH:
            return
        if request[0] not in sdo.INITIATES or request[1:4] == data[1:4]:
            self._request, self._answer = None, data
            if self._timer is not None:
                self._timer.cancel()
                self._timer = self._clock.at_tick(self._clock.ticks, partial(self._go_on, data))

    def drop(self) -> None:
        """Give everything up."""
        self._talks.clear()
        self._talk = self._request = None
        if self._timer is not None:
            self._timer.cancel()

    def _go_on(self, answer: bytes | None) -> None:
        self._timer = None
        while self._talk is not None or self._talks:
            self._talk = self._talk or self._talks.popleft()
            try:
                self._request = self._talk.send(answer)
            except StopIteration:
                self._talk = answer = None
                continue
            self._answer, self._server = None, identifiers.sdo_answer(self._node.node_id)
            self._say(self._request)
            if self._answer is None:
                self._timer = self._clock.after(self._patience, self._give_up)
                return
            answer = self._answer

    def _give_up(self) -> None:
        self._request = None
        self._go_on(None)

    def _say(self, data: bytes) -> None:
        self._send(Frame(identifiers.sdo_request(self._node.node_id), data))


class ScenarioMaster:
    """What a scenario does on the bus: it sends frames, and has an SDO client for every node."""

    def __init__(self, segment: Segment[Node], nodes: Mapping[str, Node], name: str) -> None:
        self._segment = segment
        self._wire = segment.master(name)
        self.clients = {
            node_name: SdoClient(node, segment.clock, self.send)
            for node_name, node in nodes.items()
        }
        """By the names of the nodes they ask."""

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus, and bring it to everybody if frames take no time there."""
        self._wire.put(frame)
        self._segment.deliver()

    def hear(self, frame: Frame) -> None:
        """Take a frame from the bus."""
        known = identifiers.classify(frame.can_id)
        if known is not None and known.cob is identifiers.Cob.SDO_ANSWER:
            for client in self.clients.values():
                client.hear(frame)

    def drop(self) -> None:
        """Give every transfer up."""
        for client in self.clients.values():
            client.drop()
