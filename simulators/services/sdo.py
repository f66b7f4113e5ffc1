"""SDO server: answers requests, and keeps the transfer that is open (CiA 301, 7.2.4)."""

from simulators.clock import Timer
from simulators.frame import Frame
from simulators.objects import Abort, Rejected
from simulators.services import Listening, Service, State
from simulators.services.initiate import BLOCK_DOWNLOADS, BLOCK_UPLOADS, Initiate, initiates
from simulators.services.transfer import Transfer
from simulators.slave import Slave

REQUEST_LENGTH = 8
LEFT_OPEN = Rejected("nobody went on with the transfer", Abort.TIME_OUT)
NO_OBJECT = bytes(3)  # index and sub-index of an answer that belongs to no object
ABORTS, LITERAL_ABORTS = range(0x80, 0xA0), range(0x80, 0x81)
BLOCK_INITIATES = frozenset({*BLOCK_UPLOADS, *BLOCK_DOWNLOADS})
SEGMENTS = (0, 3)  # client command specifiers: the upper three bits of a command


class SdoServer(Service):
    """Answers every request of eight bytes; one transfer is open at most."""

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self._initiates = initiates(slave.profile)
        self._aborts = LITERAL_ABORTS if slave.profile.literal_commands else ABORTS
        self._transfer: Transfer | None = None
        self._multiplexer = NO_OBJECT
        self._time_out: Timer | None = None
        self._answers = 0x580 + slave.node_id

    def listen(self) -> Listening:
        """Requests on the one fixed identifier."""
        yield (0x600 + self.slave.node_id, False), self.on_request

    def on_state(self, state: State) -> None:
        """A transfer does not outlive the states that know SDO."""
        if state not in self.active_in:
            self._close()

    def on_request(self, frame: Frame) -> None:
        """Answer, unless the frame is none of ours or the client has given up."""
        data = frame.data
        if len(data) != REQUEST_LENGTH:
            return
        transfer, initiate = self._transfer, self._initiates.get(data[0])
        try:
            if transfer is not None and transfer.continues(data[0]):
                self._continue(transfer, data)
            elif initiate is not None:
                self._initiate(initiate, data)
            elif data[0] in self._aborts:
                self._close()
            else:
                self._multiplexer = self._named(data)
                raise Rejected(_not_known(data[0]), Abort.COMMAND)
        except Rejected as refusal:
            self._refuse(refusal)

    def _continue(self, transfer: Transfer, data: bytes) -> None:
        for answer in transfer.answer(data):
            self._send(answer)
        if transfer.done:
            self._close()
        else:
            self._watch()

    def _initiate(self, initiate: Initiate, data: bytes) -> None:
        if self._transfer is not None:
            self._close()
        self._multiplexer = data[1:4]
        entry = self.slave.entry(data[1] | data[2] << 8, data[3])
        outcome = initiate(self.slave, entry, data)
        if isinstance(outcome, Transfer):
            self._transfer = outcome
            self._watch()
            outcome = outcome.opening(self._multiplexer)
        self._send(outcome)

    def _named(self, data: bytes) -> bytes:
        """The object that an unknown command belongs to."""
        if data[0] in BLOCK_INITIATES or not self.slave.profile.segmented:
            return data[1:4]  # without segments only an initiate can be meant
        return NO_OBJECT if self._transfer is None else self._multiplexer

    def _watch(self) -> None:
        if self._time_out is not None:
            self._time_out.cancel()
        time = self.slave.profile.transfer_time_out
        self._time_out = self.slave.clock.after(time, lambda: self._refuse(LEFT_OPEN))

    def _close(self) -> None:
        self._transfer = None
        if self._time_out is not None:
            self._time_out.cancel()
            self._time_out = None

    def _refuse(self, refusal: Rejected) -> None:
        self._close()
        abort = b"\x80" + self._multiplexer + refusal.code.to_bytes(4, "little")
        self.slave.wire.diary.refuse(Frame(self._answers, abort), refusal)
        self._send(abort)

    def _send(self, data: bytes) -> None:
        self.slave.wire.put(Frame(self._answers, data))


def _not_known(command: int) -> str:
    if command in BLOCK_INITIATES:
        return "there is no block transfer"
    return "a segment of no open transfer" if command >> 5 in SEGMENTS else "no such command"
