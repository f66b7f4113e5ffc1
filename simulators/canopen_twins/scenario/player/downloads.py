"""SDO downloads as seen from the bus: what a client writes, whatever the server makes of it."""

from collections.abc import Iterator
from typing import NamedTuple

from canopen_twins.scenario.sdo import (
    ABORT,
    EXPEDITED,
    EXPEDITED_ROOM,
    LAST,
    SEGMENT_ROOM,
    SIZED,
    TOGGLE,
)
from canopen_twins.slave.object import Address

DOWNLOAD_SEGMENT, DOWNLOAD, BLOCK_DOWNLOAD, BLOCK_ANSWER = 0, 1, 6, 5  # command specifiers
BLOCK_END = 1  # sub-command of the client
BLOCK_CONFIRMED = 2  # sub-command of the server
LAST_OF_BLOCKS = 0x80
LONGEST_BLOCK = 127  # segments


class Downloaded(NamedTuple):
    """A value that has been written."""

    address: Address
    data: bytes
    sized: bool = True
    """Whether all of the bytes count."""


class Segments:
    """A segmented download that is open."""

    def __init__(self, address: Address) -> None:
        self.address = address
        self.data = b""
        self._toggle = 0

    def take(self, data: bytes) -> bool:
        """Take a segment, once; whether it is the last one."""
        if data[0] & TOGGLE != self._toggle:
            return False
        self._toggle ^= TOGGLE
        self.data += data[1 : 8 - (data[0] >> 1 & 7)]
        return bool(data[0] & LAST)


class Blocks:
    """A block download that is open: what the server has not confirmed will come again."""

    def __init__(self, address: Address) -> None:
        self.address = address
        self.running = False  # every frame is a segment
        self._confirmed = b""
        self._block: list[bytes] = []

    def take(self, data: bytes) -> None:
        """Take a segment of the block that is under way."""
        if len(self._block) < LONGEST_BLOCK:
            self._block.append(data)

    def confirm(self, count: int) -> None:
        """The server has so many segments of it."""
        had = [data for number, data in enumerate(self._block, 1) if data[0] & 0x7F == number]
        self._confirmed += b"".join(data[1:] for data in had[:count])
        self.running = not any(data[0] & LAST_OF_BLOCKS for data in had[:count])
        self._block = []

    def end(self, head: int) -> bytes:
        """All of it, without the bytes that the last segment has too many."""
        return self._confirmed[: len(self._confirmed) - (head >> 2 & SEGMENT_ROOM)]


class Downloads:
    """Follows the requests of one client and, in blocks, the confirmations of its server."""

    def __init__(self) -> None:
        self._segments: Segments | None = None
        self._blocks: Blocks | None = None

    def ask(self, data: bytes) -> Iterator[Downloaded]:
        """The client has sent a request; what is complete with it."""
        specifier, segments, blocks = data[0] >> 5, self._segments, self._blocks
        if blocks is not None and blocks.running and data[0] != ABORT:
            blocks.take(data)
        elif specifier == DOWNLOAD_SEGMENT and segments is not None:
            if segments.take(data):
                self._segments = None
                yield Downloaded(segments.address, segments.data)
        elif specifier == BLOCK_DOWNLOAD and data[0] & BLOCK_END and blocks is not None:
            self._blocks = None
            yield Downloaded(blocks.address, blocks.end(data[0]))
        else:
            yield from self._initiate(data)

    def answer(self, data: bytes) -> None:
        """The server has answered."""
        if self._blocks is None:
            return
        if data[0] == ABORT:
            self._blocks = None
        elif data[0] >> 5 == BLOCK_ANSWER and data[0] & 3 == BLOCK_CONFIRMED:
            self._blocks.confirm(data[1])
        elif data[0] >> 5 == BLOCK_ANSWER:
            self._blocks.running = True

    def _initiate(self, data: bytes) -> Iterator[Downloaded]:
        self._segments = self._blocks = None
        address = data[1] | data[2] << 8, data[3]
        if data[0] >> 5 == BLOCK_DOWNLOAD and not data[0] & BLOCK_END:
            self._blocks = Blocks(address)
        elif data[0] >> 5 == DOWNLOAD and not data[0] & EXPEDITED:
            self._segments = Segments(address)
        elif data[0] >> 5 == DOWNLOAD:
            sized = bool(data[0] & SIZED)
            size = EXPEDITED_ROOM - (data[0] >> 2 & 3) if sized else EXPEDITED_ROOM
            yield Downloaded(address, data[4 : 4 + size], sized)
