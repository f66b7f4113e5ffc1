"""The scenario's own SDO client: one transfer with a node after the other, on the clock."""

from collections import deque
from collections.abc import Callable, Generator, Sequence
from functools import partial
from typing import NamedTuple

from canopen_twins.bus.clock import Clock, Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.scenario.sdo import ABORT, ACCEPTED, UNANSWERED, Answer, Request, Transfer
from canopen_twins.slave.object import Abort

ANSWER_LENGTH = 8

Send = Callable[[Frame], None]
Talk = Generator[Request, bytes | None, None]


class Job(NamedTuple):
    """Transfers of one step."""

    transfers: Sequence[Transfer]
    patience: float
    """Seconds in which every answer has to come."""
    answered: Callable[[int, Answer], bool]
    """Takes the number of a transfer and what came of it; whether to go on."""
    done: Callable[[], None]


class Client:
    """Asks one node; what is answered at once goes on at once, before anybody else's turn.

    `send` puts a frame on the bus and brings it to everybody, if frames take no time there.
    """

    def __init__(self, node: Node, clock: Clock, send: Send) -> None:
        self._node = node
        self._clock = clock
        self._send = send
        self._jobs: deque[Job] = deque()
        self._talk: Talk | None = None
        self._request: Request | None = None
        self._answer: bytes | None = None
        self._server = 0
        self._patience = 0.0
        self._timer: Timer | None = None

    def ask(self, job: Job) -> None:
        """Make transfers after those that are to be made already."""
        self._jobs.append(job)
        if self._talk is None:
            self._talk = self._work()
            self._go_on(None)

    def hear(self, frame: Frame) -> None:
        """Take a frame from the bus."""
        request = self._request
        if request is None or frame.can_id != self._server or len(frame.data) != ANSWER_LENGTH:
            return
        if request.fits(frame.data):
            self._request, self._answer = None, frame.data
            if self._timer is not None:
                self._timer.cancel()
                self._timer = self._clock.at_tick(
                    self._clock.ticks, partial(self._go_on, frame.data)
                )

    def drop(self) -> None:
        """Give everything up."""
        self._jobs.clear()
        self._talk = self._request = None
        if self._timer is not None:
            self._timer.cancel()

    def _go_on(self, answer: bytes | None) -> None:
        self._timer = None
        while self._talk is not None:
            try:
                self._request = self._talk.send(answer)
            except StopIteration:
                self._talk = None
                return
            self._answer, self._server = None, 0x580 + self._node.node_id
            self._say(self._request.data)
            if self._answer is None:
                self._timer = self._clock.after(self._patience, self._give_up)
                return
            answer = self._answer

    def _give_up(self) -> None:
        self._request = None
        self._go_on(None)

    def _say(self, data: bytes) -> None:
        self._send(Frame(0x600 + self._node.node_id, data))

    def _work(self) -> Talk:
        while self._jobs:
            job = self._jobs.popleft()
            self._patience = job.patience
            for number, transfer in enumerate(job.transfers):
                answer = yield from self._make(transfer)
                if not job.answered(number, answer):
                    break
            job.done()

    def _make(self, transfer: Transfer) -> Generator[Request, bytes | None, Answer]:
        """One transfer; the client aborts what goes wrong on its side (CiA 301, 7.2.4.3.17)."""
        request = next(transfer)
        multiplexer = request.data[1:4]
        try:
            while True:
                answer = yield request
                if answer is None:
                    self._abort(multiplexer, Abort.TIME_OUT)
                    return UNANSWERED
                request = transfer.send(answer)
        except StopIteration as end:
            result: Answer = end.value
        if result.by_client:
            self._abort(multiplexer, result.code or ACCEPTED)
        return result

    def _abort(self, multiplexer: bytes, code: int) -> None:
        self._say(bytes([ABORT]) + multiplexer + code.to_bytes(4, "little"))
