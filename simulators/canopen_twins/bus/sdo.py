"""SDO frames: what requests and answers are made of, and how they are read (CiA 301, 7.2.4.3).

Each is eight bytes, the first of them the command: a command specifier in its upper three bits,
flags below. An initiate and an abort name their object in the three bytes behind it. A segment of
a block is the exception: its first byte is its number, from 1 on, so that an abort is none.
"""

from binascii import crc_hqx
from collections.abc import Iterator

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame

Address = tuple[int, int]
"""Index and sub-index of an object."""

LENGTH = 8  # bytes of a request and of an answer
EXPEDITED_ROOM, SEGMENT_ROOM = 4, 7  # bytes of data in an initiate, and in a segment
LONGEST_BLOCK = 127  # segments

NO_OBJECT = bytes(3)  # in the place of a multiplexer, where an abort belongs to no object


class Ccs:
    """Client command specifiers: what a request is.

    Numbers: looking up the member of an Enum would take a tenth of the time of an answer.
    """

    DOWNLOAD_SEGMENT = 0
    DOWNLOAD = 1
    UPLOAD = 2
    UPLOAD_SEGMENT = 3
    ABORT = 4
    BLOCK_UPLOAD = 5
    BLOCK_DOWNLOAD = 6


class Scs:
    """Server command specifiers: what an answer is."""

    UPLOAD_SEGMENT = 0
    DOWNLOAD_SEGMENT = 1
    UPLOAD = 2
    DOWNLOAD = 3
    ABORT = 4
    BLOCK_DOWNLOAD = 5
    BLOCK_UPLOAD = 6


class Sub:
    """Sub-commands of a block transfer, in the lowest bits of its commands, of whoever it is."""

    INITIATE = 0
    END = 1
    CONFIRM = 2
    START = 3


ABORT = 0x80  # the command of an abort, whoever aborts

SIZED, EXPEDITED = 0x01, 0x02  # flags of an initiate: its size is told; the value has come along
TOGGLE, LAST = 0x10, 0x01  # of a segment; the answer to one has its toggle bit
BLOCK_SIZED, BLOCK_CRC = 0x02, 0x04  # of a block initiate: its size is told; there is a CRC
LAST_OF_BLOCKS = 0x80  # of a segment of a block: no other will follow

DOWNLOADS, UPLOADS = range(0x20, 0x40), range(0x40, 0x60)
BLOCK_UPLOADS, BLOCK_DOWNLOADS = range(0xA0, 0xC0, 4), range(0xC0, 0xE0, 2)
BLOCK_INITIATES = frozenset({*BLOCK_UPLOADS, *BLOCK_DOWNLOADS})
INITIATES = frozenset({*DOWNLOADS, *UPLOADS, *BLOCK_INITIATES})
"""Commands of requests that open a transfer, reserved bits included."""

_COMMANDS = [bytes([command]) for command in range(0x100)]
_SIZES = [EXPEDITED | SIZED | EXPEDITED_ROOM - size << 2 for size in range(EXPEDITED_ROOM + 1)]


def is_request(frame: Frame, node_id: int) -> bool:
    """Whether a frame asks the SDO server of a node."""
    its = frame.can_id == identifiers.sdo_request(node_id) and not frame.remote
    return its and len(frame.data) == LENGTH


def is_answer(frame: Frame, node_id: int) -> bool:
    """Whether a frame comes from the SDO server of a node."""
    its = frame.can_id == identifiers.sdo_answer(node_id) and not frame.remote
    return its and len(frame.data) == LENGTH


def multiplexer(address: Address) -> bytes:
    """Index and sub-index as they stand in a frame."""
    index, subindex = address
    return index.to_bytes(2, "little") + bytes([subindex])


def address(data: bytes) -> Address:
    """The object that an initiate or an abort is about."""
    return data[1] | data[2] << 8, data[3]


def specifier(data: bytes) -> int:
    """A `Ccs` or a `Scs`, or 7, which neither of them knows."""
    return data[0] >> 5


def message(specifier: int, content: bytes = b"", flags: int = 0) -> bytes:
    """Any request or answer: the command, what follows it, and zeros."""
    return (_COMMANDS[specifier << 5 | flags] + content).ljust(LENGTH, b"\0")


def abort(named: bytes, code: int) -> bytes:
    """Client or server gives up; `named` is the multiplexer of the transfer."""
    return _COMMANDS[ABORT] + named + code.to_bytes(4, "little")


def is_abort(data: bytes) -> bool:
    """Whether client or server gives up with this frame, whatever transfer is open."""
    return data[:1] == _COMMANDS[ABORT]


def abort_code(data: bytes) -> int:
    """Why."""
    return int.from_bytes(data[4:8], "little")


# Initiates: a download request and the answer to an upload look the same behind the specifier


def expedited(specifier: int, named: bytes, value: bytes, sized: bool = True) -> bytes:
    """A value of at most four bytes; without `sized` it is left open how many of them count."""
    flags = _SIZES[len(value)] if sized else EXPEDITED
    return _COMMANDS[specifier << 5 | flags] + named + value.ljust(EXPEDITED_ROOM, b"\0")


def announcing(specifier: int, named: bytes, size: int) -> bytes:
    """A value of so many bytes will come in segments."""
    return _COMMANDS[specifier << 5 | SIZED] + named + size.to_bytes(4, "little")


def is_expedited(data: bytes) -> bool:
    """Whether the value has come along with an initiate."""
    return bool(data[0] & EXPEDITED)


def size(data: bytes) -> int | None:
    """How many bytes an initiate brings or announces; none if it leaves that open."""
    command = data[0]
    if not command & SIZED:
        return None
    if command & EXPEDITED:
        return EXPEDITED_ROOM - (command >> 2 & 3)
    return int.from_bytes(data[4:8], "little")


def with_size(data: bytes, size: int) -> bytes:
    """An initiate that tells its size, with another one, whatever its data are."""
    if is_expedited(data):
        return _COMMANDS[data[0] & ~0x0C | EXPEDITED_ROOM - size << 2] + data[1:]
    return data[:4] + size.to_bytes(4, "little")


def value(data: bytes) -> bytes:
    """What an expedited initiate brings: all four bytes if it leaves open how many count."""
    return data[4 : 8 - (data[0] >> 2 & 3)] if data[0] & SIZED else data[4:8]


# Segments: those of a download and those of an upload look the same


def segments(value: bytes) -> Iterator[bytes]:
    """A value in segments, one if it is empty; the toggle bit alternates from 0 on."""
    toggle = 0
    for start in range(0, max(len(value), 1), SEGMENT_ROOM):
        part = value[start : start + SEGMENT_ROOM]
        last = LAST if start + SEGMENT_ROOM >= len(value) else 0
        unused = SEGMENT_ROOM - len(part)
        yield message(0, part, toggle | unused << 1 | last)
        toggle ^= TOGGLE


def segment_part(data: bytes) -> bytes:
    """What a segment brings."""
    return data[1 : 8 - (data[0] >> 1 & 7)]


# Segments of a block, and the end of all of them


def crc(value: bytes) -> int:
    """The checksum of a value that is transferred in blocks (7.2.4.3.16)."""
    return crc_hqx(value, 0)


def block_segment(value: bytes, place: int, number: int) -> bytes:
    """The segment at a place of a value, counted from 0; `number` counts in its block, from 1."""
    begin, end = place * SEGMENT_ROOM, (place + 1) * SEGMENT_ROOM
    head = number | (LAST_OF_BLOCKS if end >= len(value) else 0)
    return _COMMANDS[head] + value[begin:end].ljust(SEGMENT_ROOM, b"\0")


def block_number(data: bytes) -> int:
    """Which segment of its block this is, counted from 1."""
    return data[0] & ~LAST_OF_BLOCKS


def block_end(specifier: int, size: int, checksum: int) -> bytes:
    """All segments of a value of so many bytes have been confirmed."""
    unused = -size % SEGMENT_ROOM if size else SEGMENT_ROOM
    return message(specifier, checksum.to_bytes(2, "little"), unused << 2 | Sub.END)


def block_value(data: bytes, received: bytes) -> bytes:
    """What was received in segments, without what the end says is too many of the last one."""
    return received[: len(received) - (data[0] >> 2 & 7)]


def block_checksum(data: bytes) -> int:
    """The checksum that the end tells."""
    return int.from_bytes(data[1:3], "little")


READ, WRITE = "read", "write"


class Conversation:
    """Which object client and server talk about, and how far they have come, seen from the bus.

    `segment` is 0 for the initiate and counts the requests of the transfer after it.
    """

    def __init__(self) -> None:
        self.address: Address | None = None
        self.access = ""
        """`READ` or `WRITE`."""
        self.segment = 0
        self._raw = False  # segments of a block download: their first byte is no command

    def ask(self, data: bytes) -> None:
        """The client has sent a request."""
        if is_abort(data):
            self.address, self._raw = None, False
        elif data[0] in INITIATES and not self._raw:
            reads = specifier(data) in (Ccs.UPLOAD, Ccs.BLOCK_UPLOAD)
            self.address, self.access = address(data), READ if reads else WRITE
            self.segment = 0
            self._raw = specifier(data) == Ccs.BLOCK_DOWNLOAD
        else:
            self.segment += 1

    def answer(self, data: bytes) -> None:
        """The server has answered."""
        if is_abort(data) or data[:1] == _END_OF_BLOCK_DOWNLOAD:
            self._raw = False


_END_OF_BLOCK_DOWNLOAD = _COMMANDS[Scs.BLOCK_DOWNLOAD << 5 | Sub.END]
