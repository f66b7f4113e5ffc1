"""SDO server: expedited and segmented transfer (CiA 301, 7.2.4)."""

from collections.abc import Callable, Mapping

from simulators.clock import Timer
from simulators.entry import Entry
from simulators.objects import Abort, Rejected
from simulators.services import Listening, Service, State
from simulators.services.transfer import Download, Transfer, Upload
from simulators.slave import Slave
from simulators.wire import Frame

REQUEST_LENGTH = 8
EXPEDITED_ROOM = 4
NO_OBJECT = bytes(3)  # index and sub-index of an answer that belongs to no object
EXPEDITED_UPLOAD = {size: bytes([0x43 | 4 - size << 2]) for size in range(1, 5)}
LITERAL_COMMANDS = frozenset({*range(0x20, 0x30), 0x40, 0x80})

Handler = Callable[[bytes], bytes | None]


class SdoServer(Service):
    """Answers every request of eight bytes; one transfer is open at most."""

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self._commands: Mapping[int, Handler] = {
            0: self._segment_of(Download),
            1: self._initiate_download,
            2: self._initiate_upload,
            3: self._segment_of(Upload),
            4: self._client_abort,
        }
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
        try:
            answer = self._command(data)
        except Rejected as refusal:
            self._close()
            answer = abort(self._multiplexer, refusal.code)
        if answer is not None:
            self.slave.wire.put(Frame(self._answers, answer))

    def _command(self, data: bytes) -> bytes | None:
        handler = self._commands.get(data[0] >> 5)
        profile = self.slave.profile
        if handler is None or (profile.literal_commands and data[0] not in LITERAL_COMMANDS):
            # a block initiate names an object, what is not known at all does not (as far as
            # segments exist: without them nothing but initiates can have been meant)
            named = data[0] >> 5 in (5, 6) or not profile.segmented
            self._multiplexer = data[1:4] if named else NO_OBJECT
            raise Rejected("unknown command specifier", Abort.COMMAND)
        return handler(data)

    def _initiate_upload(self, data: bytes) -> bytes:
        entry = self._open(data)
        if not entry.readable:
            raise Rejected("write only", Abort.WRITE_ONLY)
        value = entry.read()
        if head := EXPEDITED_UPLOAD.get(len(value)):
            return head + data[1:4] + value.ljust(EXPEDITED_ROOM, b"\0")
        if not self.slave.profile.segmented:
            raise Rejected(f"{len(value)} bytes fit no expedited transfer", Abort.NOT_TRANSFERABLE)
        self._begin(Upload(value))
        return b"\x41" + data[1:4] + len(value).to_bytes(4, "little")

    def _initiate_download(self, data: bytes) -> bytes:
        entry = self._open(data)
        expedited, sized = data[0] & 2, data[0] & 1
        if expedited:
            size = EXPEDITED_ROOM - (data[0] >> 2 & 3) if sized else None
        else:
            size = int.from_bytes(data[4:], "little") if sized else None
        self._check_download(entry, size)
        if not expedited:
            return self._begin_download(entry, size, data)
        room = entry.size if size is None else size  # without a size as many as the object has
        self.slave.write(entry, data[4 : 4 + (EXPEDITED_ROOM if room is None else room)])
        return b"\x60" + data[1:4] + bytes(4)

    def _begin_download(self, entry: Entry, size: int | None, data: bytes) -> bytes:
        if not self.slave.profile.segmented:
            raise Rejected("no segmented transfer", Abort.COMMAND)
        longest = self.slave.profile.longest_transfer if entry.size is None else entry.size
        if size is not None and size > longest:
            raise Rejected(f"{size} bytes are more than {longest}", self.slave.profile.too_long)
        self._begin(Download(entry, self.slave, longest, size))
        return b"\x60" + data[1:4] + bytes(4)

    def _check_download(self, entry: Entry, size: int | None) -> None:
        checks = [self._check_access, self._check_length]
        if self.slave.profile.length_before_access:
            checks.reverse()
        for check in checks:
            check(entry, size)

    def _check_access(self, entry: Entry, size: int | None) -> None:
        if not entry.writable:
            raise Rejected("read only", Abort.READ_ONLY)

    def _check_length(self, entry: Entry, size: int | None) -> None:
        if size is not None:
            self.slave.check_length(entry, size)

    def _segment_of(self, kind: type[Transfer]) -> Handler:
        def segment(data: bytes) -> bytes:
            transfer = self._transfer
            if not isinstance(transfer, kind):
                named = not self.slave.profile.segmented
                self._multiplexer = data[1:4] if named else NO_OBJECT
                raise Rejected("no such transfer is open", Abort.COMMAND)
            answer = transfer.segment(data)
            if transfer.done:
                self._close()
            else:
                self._watch()
            return answer

        return segment

    def _client_abort(self, data: bytes) -> None:
        self._close()

    def _open(self, data: bytes) -> Entry:
        """The entry an initiate names; whatever was open before ends."""
        if self._transfer is not None:
            self._close()
        self._multiplexer = data[1:4]
        return self.slave.entry(data[1] | data[2] << 8, data[3])

    def _begin(self, transfer: Transfer) -> None:
        self._transfer = transfer
        self._watch()

    def _watch(self) -> None:
        if self._time_out is not None:
            self._time_out.cancel()
        self._time_out = self.slave.clock.after(self.slave.profile.transfer_time_out, self._give_up)

    def _give_up(self) -> None:
        self._close()
        self.slave.wire.put(Frame(self._answers, abort(self._multiplexer, Abort.TIME_OUT)))

    def _close(self) -> None:
        self._transfer = None
        if self._time_out is not None:
            self._time_out.cancel()
            self._time_out = None


def abort(multiplexer: bytes, code: int) -> bytes:
    """An abort of the transfer of an object."""
    return b"\x80" + multiplexer + code.to_bytes(4, "little")
