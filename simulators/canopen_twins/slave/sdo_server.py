"""SDO servers: each initiate is answered at once or opens a transfer (CiA 301, 7.2.4.3)."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Ccs, Scs
from canopen_twins.slave.object import Abort, Address, Entry, Object, Rejected
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.request_buffer import RequestBuffer
from canopen_twins.slave.sdo_transfer import (
    BlockDownload,
    BlockUpload,
    Download,
    Target,
    Transfer,
    Upload,
)
from canopen_twins.slave.service import (
    Listening,
    Service,
    State,
    check_cob_id,
    give_default,
)
from canopen_twins.slave.slave import Slave

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

    def on_request(self, frame: Frame) -> bool:
        """Answer, unless the frame is none of ours or the client has given up.

        Whether that was no more than a look: a value was read, in one frame.
        """
        data = frame.data
        if len(data) != sdo.LENGTH:
            return False
        transfer, initiate = self._transfer, self._offered.get(data[0])
        try:
            if transfer is not None and transfer.continues(data[0]):
                self._continue(transfer, data)
            elif initiate is not None:
                return self._initiate(initiate, data)
            elif data[0] in self._aborts:
                self._close()
            else:
                self._named = self._meant(data)
                raise Rejected(_not_known(data[0]), Abort.COMMAND)
        except Rejected as refusal:
            self._refuse(refusal)
        return False

    def _continue(self, transfer: Transfer, data: bytes) -> None:
        for answer in transfer.answer(data):
            self.slave.send(Frame(self._answers, answer))
        if transfer.done:
            self._close()
        else:
            self._watch()

    def _initiate(self, initiate: Initiate, data: bytes) -> bool:
        if self._transfer is not None:
            self._close()
        self._named = data[1:4]
        entry = self.slave.entry(data[1] | data[2] << 8, data[3])
        outcome = initiate(self.slave, entry, data)
        looked = initiate is upload
        if not isinstance(outcome, bytes):
            self._transfer, looked = outcome, False
            self._watch()
            outcome = outcome.opening(self._named)
        self.slave.send(Frame(self._answers, outcome))
        return looked

    def _meant(self, data: bytes) -> bytes:
        """The multiplexer of the object that an unknown command belongs to."""
        profile = self.slave.profile
        if data[0] in (sdo.BLOCK_INITIATES if profile.segmented else sdo.INITIATES):
            return data[1:4]
        if profile.literal_commands and not profile.segmented:
            return data[1:4]  # a command is all it can mean
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


SERVERS = range(0x1201, 0x1280)  # beyond the one of 0x1200
REQUESTS, ANSWERS = 1, 2  # sub-indices: COB-ID from the client, and to it


class FurtherSdoServer(SdoServer):
    """One of 0x1201 and on: there while neither of its identifiers is off (7.5.2.34)."""

    def __init__(self, slave: Slave, index: int) -> None:
        super().__init__(slave)
        self._index = index
        for subindex in (REQUESTS, ANSWERS):
            give_default(slave, (index, subindex), identifiers.INVALID)

    @classmethod
    def all(cls, slave: Slave) -> Iterator[Service]:
        """Those that the dictionary has."""
        for index in sorted(index for index in slave.entries if index in SERVERS):
            record = slave.entries[index]
            cob_ids = [record[sub] for sub in (REQUESTS, ANSWERS) if sub in record]
            if len(cob_ids) == 2 and all(entry.is_whole for entry in cob_ids):
                yield cls(slave, index)

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The rules for its identifiers."""
        subindices = (REQUESTS, ANSWERS)
        return {(self._index, sub): Object(write=partial(self._check, sub)) for sub in subindices}

    def listen(self) -> Listening:
        """Requests on the identifier of its record."""
        requests, answers = self._cob_ids
        if requests is None or answers is None:
            self._close()
            return
        self._answers = answers
        yield (requests, False), self.on_request

    @property
    def _cob_ids(self) -> list[int | None]:
        numbers = (self.slave.number(self._index, sub) for sub in (REQUESTS, ANSWERS))
        return [identifiers.of_cob_id(number) for number in numbers]

    def _check(self, subindex: int, value: int) -> None:
        """What the file has may be taken into use, though 7.3.5 restricts what many have."""
        entry = self.slave.entry(self._index, subindex)
        before, delivered = entry.unpack(entry.read()), entry.unpack(entry.initial)
        in_use = None not in self._cob_ids
        if in_use and not value & identifiers.INVALID and value != before:
            raise Rejected("bit 31 has to be set before the identifier changes")
        if not delivered or (delivered ^ value) & ~identifiers.INVALID:
            check_cob_id(value)
