"""SDO server: each initiate is answered at once or opens a transfer (CiA 301, 7.2.4.3)."""

from collections.abc import Callable, Mapping, Sequence

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Ccs, Scs, Sub
from canopen_twins.slave.object import Abort, Entry, Rejected
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.request_buffer import RequestBuffer
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave


class Transfer:
    """One open transfer; it ends when it is `done` or with the first `Rejected`."""

    done = False

    def opening(self, named: bytes) -> bytes:
        """The answer to the initiate, given its multiplexer."""
        raise NotImplementedError

    def continues(self, command: int) -> bool:
        """Whether a request with this command byte belongs to the transfer."""
        raise NotImplementedError

    def is_silent(self, data: bytes) -> bool:
        """Whether such a request has no answer of its own, and does not wait for its turn."""
        return False

    def answer(self, data: bytes) -> Sequence[bytes]:
        """What to say to such a request.

        Raises:
            Rejected: the transfer is over.
        """
        raise NotImplementedError


class Target:
    """The entry that a download writes, and how many bytes it may bring."""

    def __init__(self, slave: Slave, entry: Entry, announced: int | None) -> None:
        """Raises `Rejected` if more is announced than there is room for."""
        self._slave = slave
        self._entry = entry
        self._announced = announced
        self._longest = slave.profile.longest_transfer if entry.size is None else entry.size
        if announced is not None:
            self.check(announced)
            self._longest = announced

    def check(self, length: int) -> None:
        """Raises `Rejected` if so many bytes are too many."""
        if length > self._longest:
            reason = f"{length} bytes are more than {self._longest}"
            raise Rejected(reason, self._slave.profile.too_long)

    def write(self, data: bytes) -> None:
        """Write all there is.

        Raises:
            Rejected: not as many bytes as announced, or refused by the entry.
        """
        self.check(len(data))
        if self._announced is not None and len(data) < self._announced:
            reason = f"{len(data)} bytes are fewer than {self._announced}"
            raise Rejected(reason, self._slave.profile.too_short)
        self._slave.write(self._entry, data)


class Segmented(Transfer):
    """Segments with a toggle bit, each answered by one (7.2.4.3.3-8)."""

    specifier: int
    """Of its requests."""

    def __init__(self) -> None:
        self._toggle = 0

    def continues(self, command: int) -> bool:
        """By the specifier alone: a wrong toggle bit belongs to it, too."""
        return command >> 5 == self.specifier

    def answer(self, data: bytes) -> Sequence[bytes]:
        """Answer the next segment."""
        if data[0] & sdo.TOGGLE != self._toggle:
            raise Rejected("toggle bit did not alternate", Abort.TOGGLE)
        answer = self._exchange(data)
        self._toggle ^= sdo.TOGGLE
        return [answer]

    def _exchange(self, data: bytes) -> bytes:
        raise NotImplementedError


class Upload(Segmented):
    """From the server to the client: the value as it was when the transfer began."""

    specifier = Ccs.UPLOAD_SEGMENT

    def __init__(self, value: bytes) -> None:
        super().__init__()
        self._size = len(value)
        self._segments = sdo.segments(value)

    def opening(self, named: bytes) -> bytes:
        """The size of the value."""
        return sdo.announcing(Scs.UPLOAD, named, self._size)

    def _exchange(self, data: bytes) -> bytes:
        segment = next(self._segments)
        self.done = bool(segment[0] & sdo.LAST)
        return segment


class Download(Segmented):
    """From the client to the server: nothing is written before the last segment is there."""

    specifier = Ccs.DOWNLOAD_SEGMENT

    def __init__(self, target: Target) -> None:
        super().__init__()
        self._target = target
        self._data = b""

    def opening(self, named: bytes) -> bytes:
        """Go ahead."""
        return sdo.message(Scs.DOWNLOAD, named)

    def _exchange(self, data: bytes) -> bytes:
        self._data += sdo.segment_part(data)
        self._target.check(len(self._data))
        if data[0] & sdo.LAST:
            self._target.write(self._data)
            self.done = True
        return sdo.message(Scs.DOWNLOAD_SEGMENT, flags=self._toggle)


class BlockUpload(Transfer):
    """To the client, in blocks as long as it wants the next one (7.2.4.3.13-15)."""

    def __init__(self, value: bytes, blksize: int, crc: bool) -> None:
        """Raises `Rejected` if blocks are not of 1..127 segments."""
        self._value = value
        self._crc = sdo.crc(value) if crc else 0
        self._segments = max(-(-len(value) // sdo.SEGMENT_ROOM), 1)
        self._confirmed = 0
        self._sent = 0  # of the block that is under way
        self._expected = Sub.START
        self._set_blksize(blksize)

    def opening(self, named: bytes) -> bytes:
        """The size of the value."""
        size = len(self._value).to_bytes(4, "little")
        return sdo.message(Scs.BLOCK_UPLOAD, named + size, sdo.BLOCK_CRC | sdo.BLOCK_SIZED)

    def continues(self, command: int) -> bool:
        """Everything of block upload but a new initiate."""
        return command >> 5 == Ccs.BLOCK_UPLOAD and command & 3 != Sub.INITIATE

    def answer(self, data: bytes) -> Sequence[bytes]:
        """The next block, or the one that was not received as a whole, or the end."""
        if data[0] & 3 != self._expected:
            raise Rejected("not the turn of this sub-command", Abort.COMMAND)
        if self._expected == Sub.END:
            self.done = True
            return []
        if self._expected == Sub.CONFIRM:
            self._confirm(data[1])
            self._set_blksize(data[2])
        return self._block() if self._confirmed < self._segments else self._end()

    def _set_blksize(self, blksize: int) -> None:
        if not 1 <= blksize <= sdo.LONGEST_BLOCK:
            raise Rejected(f"no blocks of {blksize} segments", Abort.BLOCK_SIZE)
        self._blksize = blksize

    def _confirm(self, ackseq: int) -> None:
        if ackseq > self._sent:
            raise Rejected(f"no segment {ackseq} was sent", Abort.SEQUENCE_NUMBER)
        self._confirmed += ackseq

    def _block(self) -> Sequence[bytes]:
        self._expected = Sub.CONFIRM
        self._sent = min(self._blksize, self._segments - self._confirmed)
        return [
            sdo.block_segment(self._value, self._confirmed + place, place + 1)
            for place in range(self._sent)
        ]

    def _end(self) -> Sequence[bytes]:
        self._expected = Sub.END
        return [sdo.block_end(Scs.BLOCK_UPLOAD, len(self._value), self._crc)]


class BlockDownload(Transfer):
    """To the server; what follows a gap in a block has to be sent again (7.2.4.3.9-12)."""

    def __init__(self, target: Target, crc: bool) -> None:
        self._target = target
        self._checks_crc = crc
        self._data = b""
        self._received = 0  # segments of the block that is under way
        self._complete = False

    def opening(self, named: bytes) -> bytes:
        """How long blocks are."""
        return sdo.message(
            Scs.BLOCK_DOWNLOAD, named + bytes([sdo.LONGEST_BLOCK]), sdo.BLOCK_CRC | Sub.INITIATE
        )

    def continues(self, command: int) -> bool:
        """While a block is under way every frame is a segment of it."""
        if self._complete:
            return command >> 5 == Ccs.BLOCK_DOWNLOAD and command & 3 == Sub.END
        return command != sdo.ABORT

    def is_silent(self, data: bytes) -> bool:
        """All segments of a block but the last one."""
        last = data[0] & sdo.LAST_OF_BLOCKS or sdo.block_number(data) == sdo.LONGEST_BLOCK
        return not self._complete and data[0] != sdo.ABORT and not last

    def answer(self, data: bytes) -> Sequence[bytes]:
        """Confirm a block when its last segment is there, and the transfer at its end."""
        if self._complete:
            return self._end(data)
        number = sdo.block_number(data)
        if not number:
            raise Rejected("segments are numbered from 1", Abort.SEQUENCE_NUMBER)
        last = bool(data[0] & sdo.LAST_OF_BLOCKS)
        if number == self._received + 1:
            self._received = number
            self._data += data[1:]
            self._complete = last
        return self._confirm() if last or number == sdo.LONGEST_BLOCK else []

    def _confirm(self) -> Sequence[bytes]:
        unused_at_most = sdo.SEGMENT_ROOM if self._complete else 0
        self._target.check(len(self._data) - unused_at_most)
        ackseq, self._received = self._received, 0
        content = bytes([ackseq, sdo.LONGEST_BLOCK])
        return [sdo.message(Scs.BLOCK_DOWNLOAD, content, Sub.CONFIRM)]

    def _end(self, data: bytes) -> Sequence[bytes]:
        value = sdo.block_value(data, self._data)
        if self._checks_crc and sdo.crc(value) != sdo.block_checksum(data):
            raise Rejected("the CRC is wrong", Abort.CRC)
        self._target.write(value)
        self.done = True
        return [sdo.message(Scs.BLOCK_DOWNLOAD, flags=Sub.END)]


Initiate = Callable[[Slave, Entry, bytes], bytes | Transfer]
"""Answers a request about an entry, or opens a transfer; raises `Rejected`."""


def upload(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Read, in one frame if the value fits."""
    return _uploaded(slave, data, _read(entry))


def block_upload(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Read in blocks, unless the value is so short that the client wants it the other way."""
    value, blksize, switch_up_to = _read(entry), data[4], data[5]
    if switch_up_to and len(value) <= switch_up_to:
        return _uploaded(slave, data, value)
    return BlockUpload(value, blksize, crc=bool(data[0] & sdo.BLOCK_CRC))


def download(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Write, at once if the value has come along."""
    size = sdo.size(data)
    _check_download(slave, entry, size)
    if not data[0] & sdo.EXPEDITED:
        return Download(Target(slave, entry, size))
    room = entry.size if size is None else size  # without a size as many as the object has
    slave.write(entry, data[4:8] if room is None else data[4 : 4 + room])
    return sdo.message(Scs.DOWNLOAD, data[1:4])


def block_download(slave: Slave, entry: Entry, data: bytes) -> bytes | Transfer:
    """Write in blocks."""
    size = int.from_bytes(data[4:], "little") if data[0] & sdo.BLOCK_SIZED else None
    _check_download(slave, entry, size)
    return BlockDownload(Target(slave, entry, size), crc=bool(data[0] & sdo.BLOCK_CRC))


def _read(entry: Entry) -> bytes:
    if not entry.readable:
        raise Rejected("write only", Abort.WRITE_ONLY)
    return entry.read()


def _uploaded(slave: Slave, data: bytes, value: bytes) -> bytes | Transfer:
    if 0 < len(value) <= sdo.EXPEDITED_ROOM:
        return sdo.expedited(Scs.UPLOAD, data[1:4], value)
    if not slave.profile.segmented:
        raise Rejected(f"{len(value)} bytes fit no expedited transfer", Abort.NOT_TRANSFERABLE)
    return Upload(value)


def _check_download(slave: Slave, entry: Entry, size: int | None) -> None:
    """Access and length, in the order in which the device checks them."""
    if size is not None and slave.profile.length_before_access:
        slave.check_length(entry, size)
    if not entry.writable:
        raise Rejected("read only", Abort.READ_ONLY)
    if size is not None:
        slave.check_length(entry, size)


LITERAL_COMMANDS = frozenset({*range(0x20, 0x30), 0x40})
ABORTS, LITERAL_ABORTS = range(sdo.ABORT, sdo.ABORT + 0x20), range(sdo.ABORT, sdo.ABORT + 1)
SEGMENTS = (Ccs.DOWNLOAD_SEGMENT, Ccs.UPLOAD_SEGMENT)
LEFT_OPEN = Rejected("nobody went on with the transfer", Abort.TIME_OUT)


def offered(profile: Profile) -> Mapping[int, Initiate]:
    """The initiates that the server knows, by command byte."""
    table: dict[int, Initiate] = dict.fromkeys(sdo.DOWNLOADS, download)
    if not profile.segmented and not profile.literal_commands:  # literally, 20h and 21h are known
        table = {command: table[command] for command in table if command & sdo.EXPEDITED}
    table |= dict.fromkeys(sdo.UPLOADS, upload)
    if profile.block:
        table |= dict.fromkeys(sdo.BLOCK_DOWNLOADS, block_download)
        table |= dict.fromkeys(sdo.BLOCK_UPLOADS, block_upload)
    if profile.literal_commands:
        return {command: table[command] for command in table if command in LITERAL_COMMANDS}
    return table


class SdoServer(Service):
    """Answers every request of eight bytes; one transfer is open at most."""

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})

    def __init__(self, slave: Slave, buffer: RequestBuffer | None = None) -> None:
        """Without a buffer every request is answered at once."""
        super().__init__(slave)
        self._buffer = buffer
        self._offered = offered(slave.profile)
        self._aborts = LITERAL_ABORTS if slave.profile.literal_commands else ABORTS
        self._transfer: Transfer | None = None
        self._named = sdo.NO_OBJECT  # multiplexer of the last initiate
        self._time_out: Timer | None = None
        self._answers = identifiers.sdo_answer(slave.node_id)

    def listen(self) -> Listening:
        """Requests on the one fixed identifier."""
        handle = self.on_request if self._buffer is None else self._take
        yield (identifiers.sdo_request(self.slave.node_id), False), handle

    def on_state(self, state: State) -> None:
        """A transfer does not outlive the states that know SDO."""
        if state not in self.active_in:
            self._close()
            if self._buffer is not None:
                self._buffer.clear()

    def _take(self, frame: Frame) -> None:
        """Wait for its turn, unless nobody waits for an answer; an empty frame is no request."""
        silent = self._transfer is not None and self._transfer.is_silent(frame.data)
        if self._buffer is None or silent or len(frame.data) != sdo.LENGTH:
            self.on_request(frame)
        else:
            self._buffer.take(frame, self.on_request)

    def on_request(self, frame: Frame) -> None:
        """Answer, unless the frame is none of ours or the client has given up."""
        data = frame.data
        if len(data) != sdo.LENGTH:
            return
        transfer, initiate = self._transfer, self._offered.get(data[0])
        try:
            if transfer is not None and transfer.continues(data[0]):
                self._continue(transfer, data)
            elif initiate is not None:
                self._initiate(initiate, data)
            elif data[0] in self._aborts:
                self._close()
            else:
                self._named = self._meant(data)
                raise Rejected(_not_known(data[0]), Abort.COMMAND)
        except Rejected as refusal:
            self._refuse(refusal)

    def _continue(self, transfer: Transfer, data: bytes) -> None:
        for answer in transfer.answer(data):
            self.slave.send(Frame(self._answers, answer))
        if transfer.done:
            self._close()
        else:
            self._watch()

    def _initiate(self, initiate: Initiate, data: bytes) -> None:
        if self._transfer is not None:
            self._close()
        self._named = data[1:4]
        entry = self.slave.entry(data[1] | data[2] << 8, data[3])
        outcome = initiate(self.slave, entry, data)
        if not isinstance(outcome, bytes):
            self._transfer = outcome
            self._watch()
            outcome = outcome.opening(self._named)
        self.slave.send(Frame(self._answers, outcome))

    def _meant(self, data: bytes) -> bytes:
        """The multiplexer of the object that an unknown command belongs to."""
        if data[0] in sdo.BLOCK_INITIATES or not self.slave.profile.segmented:
            return data[1:4]  # without segments only an initiate can be meant
        return sdo.NO_OBJECT if self._transfer is None else self._named

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
        answer = Frame(self._answers, sdo.abort(self._named, refusal.code))
        self.slave.wire.events.add_refusal(answer, refusal)
        self.slave.send(answer)


def _not_known(command: int) -> str:
    if command in sdo.BLOCK_INITIATES:
        return "there is no block transfer"
    return "a segment of no open transfer" if command >> 5 in SEGMENTS else "no such command"
