"""SDO initiates: each is answered at once or begins a transfer (CiA 301, 7.2.4.3)."""

from collections.abc import Callable, Mapping

from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Abort, Entry, Rejected
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.sdo.block import BlockDownload, BlockUpload
from canopen_twins.slave.sdo.segmented import Download, Target, Transfer, Upload
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

EXPEDITED_ROOM = 4
EXPEDITED_UPLOAD = {size: bytes([0x43 | 4 - size << 2]) for size in range(1, 5)}

DOWNLOADS, UPLOADS = range(0x20, 0x40), range(0x40, 0x60)
BLOCK_UPLOADS, BLOCK_DOWNLOADS = range(0xA0, 0xC0, 4), range(0xC0, 0xE0, 2)
LITERAL_COMMANDS = frozenset({*range(0x20, 0x30), 0x40})
EXPEDITED = 2  # bit of a download: the value has come along

Initiate = Callable[[Slave, Entry, bytes], bytes | Transfer]


def initiates(profile: Profile) -> Mapping[int, Initiate]:
    """What the server offers, by command byte."""
    table: dict[int, Initiate] = dict.fromkeys(DOWNLOADS, download)
    if not profile.segmented and not profile.literal_commands:  # literally, 20h and 21h are known
        table = {command: table[command] for command in table if command & EXPEDITED}
    table |= dict.fromkeys(UPLOADS, upload)
    if profile.block:
        table |= dict.fromkeys(BLOCK_DOWNLOADS, block_download)
        table |= dict.fromkeys(BLOCK_UPLOADS, block_upload)
    if profile.literal_commands:
        return {command: table[command] for command in table if command in LITERAL_COMMANDS}
    return table


def upload(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Read, in one frame if the value fits."""
    return _upload(slave, data, _read(entry))


def block_upload(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Read in blocks, unless the value is so short that the client wants it the other way."""
    value, blksize, switch_up_to = _read(entry), data[4], data[5]
    if switch_up_to and len(value) <= switch_up_to:
        return _upload(slave, data, value)
    return BlockUpload(value, blksize, crc=bool(data[0] & 4))


def download(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Write, at once if the value has come along."""
    if not data[0] & EXPEDITED:
        size = int.from_bytes(data[4:], "little") if data[0] & 1 else None
        _check_download(slave, entry, size)
        return Download(Target(slave, entry, size))
    size = EXPEDITED_ROOM - (data[0] >> 2 & 3) if data[0] & 1 else None
    _check_download(slave, entry, size)
    room = entry.size if size is None else size  # without a size as many as the object has
    slave.write(entry, data[4 : 4 + (EXPEDITED_ROOM if room is None else room)])
    return b"\x60" + data[1:4] + bytes(4)


def block_download(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Write in blocks."""
    size = int.from_bytes(data[4:], "little") if data[0] & 2 else None
    _check_download(slave, entry, size)
    return BlockDownload(Target(slave, entry, size), crc=bool(data[0] & 4))


def _read(entry: Entry) -> bytes:
    if not entry.readable:
        raise Rejected("write only", Abort.WRITE_ONLY)
    return entry.read()


def _upload(slave: Slave, data: bytes, value: bytes) -> bytes | Transfer:
    if head := EXPEDITED_UPLOAD.get(len(value)):
        return head + data[1:4] + value.ljust(EXPEDITED_ROOM, b"\0")
    if not slave.profile.segmented:
        raise Rejected(f"{len(value)} bytes fit no expedited transfer", Abort.NOT_TRANSFERABLE)
    return Upload(value)


def _check_download(slave: Slave, entry: Entry, size: int | None) -> None:
    checks = [_check_access, _check_length]
    if slave.profile.length_before_access:
        checks.reverse()
    for check in checks:
        check(slave, entry, size)


def _check_access(slave: Slave, entry: Entry, size: int | None) -> None:
    if not entry.writable:
        raise Rejected("read only", Abort.READ_ONLY)


def _check_length(slave: Slave, entry: Entry, size: int | None) -> None:
    if size is not None:
        slave.check_length(entry, size)


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
