"""Block SDO transfers (CiA 301, 7.2.4.3.9-17): many segments for one confirmation, with a CRC."""

from binascii import crc_hqx
from collections.abc import Sequence
from enum import IntEnum

from canopen_twins.slave.object import Abort, Rejected
from canopen_twins.slave.sdo.segmented import SEGMENT_ROOM, Target, Transfer

UPLOAD = 5  # command specifier of the client
LONGEST_BLOCK = 127  # segments
LAST = 1 << 7
ABORT = 0x80  # no segment: they are numbered from 1
END_OF_DOWNLOAD, END_MASK = 0xC1, 0xE3


class Step(IntEnum):
    """What the client says next in a block upload: its sub-command."""

    END = 1
    CONFIRM = 2
    START = 3


class BlockUpload(Transfer):
    """From the server to the client, in blocks as long as the client wants the next one."""

    def __init__(self, value: bytes, blksize: int, crc: bool) -> None:
        """Raises `Rejected` if blocks are not of 1..127 segments."""
        self._value = value
        self._crc = crc_hqx(value, 0) if crc else 0
        self._segments = max(-(-len(value) // SEGMENT_ROOM), 1)
        self._confirmed = 0
        self._sent = 0  # of the block that is under way
        self._expected = Step.START
        self._set_blksize(blksize)

    def opening(self, multiplexer: bytes) -> bytes:
        """The size of the value."""
        return b"\xc6" + multiplexer + len(self._value).to_bytes(4, "little")

    def continues(self, command: int) -> bool:
        """Everything of block upload but a new initiate."""
        return command >> 5 == UPLOAD and bool(command & 3)

    def answer(self, data: bytes) -> Sequence[bytes]:
        """The next block, or the one that was not received as a whole, or the end."""
        if data[0] & 3 != self._expected:
            raise Rejected("not the turn of this sub-command", Abort.COMMAND)
        if self._expected is Step.END:
            self.done = True
            return []
        if self._expected is Step.CONFIRM:
            self._confirm(data[1])
            self._set_blksize(data[2])
        return self._end() if self._confirmed == self._segments else self._block()

    def _set_blksize(self, blksize: int) -> None:
        if not 1 <= blksize <= LONGEST_BLOCK:
            raise Rejected(f"no blocks of {blksize} segments", Abort.BLOCK_SIZE)
        self._blksize = blksize

    def _confirm(self, ackseq: int) -> None:
        if ackseq > self._sent:
            raise Rejected(f"no segment {ackseq} was sent", Abort.SEQUENCE_NUMBER)
        self._confirmed += ackseq

    def _block(self) -> Sequence[bytes]:
        self._expected = Step.CONFIRM
        self._sent = min(self._blksize, self._segments - self._confirmed)
        return [self._segment(number) for number in range(1, self._sent + 1)]

    def _segment(self, number: int) -> bytes:
        end = (self._confirmed + number) * SEGMENT_ROOM
        head = number | (LAST if end >= len(self._value) else 0)
        return bytes([head]) + self._value[end - SEGMENT_ROOM : end].ljust(SEGMENT_ROOM, b"\0")

    def _end(self) -> Sequence[bytes]:
        self._expected = Step.END
        unused = self._segments * SEGMENT_ROOM - len(self._value)
        return [bytes([0xC1 | unused << 2]) + self._crc.to_bytes(2, "little") + bytes(5)]


class BlockDownload(Transfer):
    """From the client to the server; what follows a gap in a block has to be sent again."""

    def __init__(self, target: Target, crc: bool) -> None:
        self._target = target
        self._checks_crc = crc
        self._data = b""
        self._received = 0  # segments of the block that is under way
        self._complete = False

    def opening(self, multiplexer: bytes) -> bytes:
        """How long blocks are."""
        return b"\xa4" + multiplexer + bytes([LONGEST_BLOCK, 0, 0, 0])

    def continues(self, command: int) -> bool:
        """While a block is under way every frame is a segment of it."""
        if self._complete:
            return command & END_MASK == END_OF_DOWNLOAD
        return command != ABORT

    def answer(self, data: bytes) -> Sequence[bytes]:
        """Confirm a block when its last segment is there, and the transfer at its end."""
        if self._complete:
            return self._end(data)
        number, last = data[0] & ~LAST, bool(data[0] & LAST)
        if not number:
            raise Rejected("segments are numbered from 1", Abort.SEQUENCE_NUMBER)
        if number == self._received + 1:
            self._received = number
            self._data += data[1:]
            self._complete = last
        return self._confirm() if last or number == LONGEST_BLOCK else []

    def _confirm(self) -> Sequence[bytes]:
        unused_at_most = SEGMENT_ROOM if self._complete else 0
        self._target.check(len(self._data) - unused_at_most)
        ackseq, self._received = self._received, 0
        return [bytes([0xA2, ackseq, LONGEST_BLOCK]) + bytes(5)]

    def _end(self, data: bytes) -> Sequence[bytes]:
        content = self._data[: len(self._data) - (data[0] >> 2 & 7)]
        if self._checks_crc and crc_hqx(content, 0) != int.from_bytes(data[1:3], "little"):
            raise Rejected("the CRC is wrong", Abort.CRC)
        self._target.write(content)
        self.done = True
        return [b"\xa1" + bytes(SEGMENT_ROOM)]
