"""SDO transfers as a client makes them, whatever the time between request and answer."""

from collections.abc import Callable, Generator, Iterator
from typing import NamedTuple

from canopen_twins.slave.object import Abort, Address

EXPEDITED_ROOM, SEGMENT_ROOM = 4, 7
ACCEPTED = 0
ABORT = 0x80
TOGGLE = 0x10
SIZED, EXPEDITED = 1, 2  # bits of an initiate
LAST = 1  # bit of a segment


class Answer(NamedTuple):
    """What came of a transfer."""

    code: int | None
    """`ACCEPTED`, the abort code, or None if there was no answer in time."""
    data: bytes = b""
    """What has been read."""
    by_client: bool = False
    """Whether it was the client that had to abort, as the answer was none to its request."""


UNANSWERED = Answer(None)


class Request(NamedTuple):
    """A request, and which frames of the server can be its answer."""

    data: bytes
    fits: Callable[[bytes], bool]


Transfer = Generator[Request, bytes, Answer]
"""Gives requests, takes their answers, and returns what came of it."""


def multiplexer(address: Address) -> bytes:
    """Index and sub-index as they stand in a frame."""
    index, subindex = address
    return index.to_bytes(2, "little") + bytes([subindex])


def abort(address: Address, code: int) -> bytes:
    """The client gives up."""
    return bytes([ABORT]) + multiplexer(address) + code.to_bytes(4, "little")


def download(address: Address, data: bytes, sized: bool = True) -> Transfer:
    """Write; what fits goes in one frame, and without `sized` it leaves open how many bytes count.

    More than four bytes go in segments.
    """
    if len(data) <= EXPEDITED_ROOM:
        head = 0x20 | EXPEDITED | ((EXPEDITED_ROOM - len(data) << 2 | SIZED) if sized else 0)
        answer = yield _initiate(head, address, data.ljust(EXPEDITED_ROOM, b"\0"))
        return _result(answer, 0x60)
    answer = yield _initiate(0x20 | SIZED, address, len(data).to_bytes(4, "little"))
    result = _result(answer, 0x60)
    for request in _segments(data):
        if result.code == ACCEPTED:
            answer = yield _segment(request)
            result = _result(answer, 0x20 | request[0] & TOGGLE)
    return result


def upload(address: Address) -> Transfer:
    """Read, in one frame or in segments as the server wants it."""
    answer = yield _initiate(0x40, address, bytes(EXPEDITED_ROOM))
    if answer[0] & 0xE0 != 0x40:
        return _result(answer, 0x40)
    if answer[0] & EXPEDITED:
        unused = answer[0] >> 2 & 3 if answer[0] & SIZED else 0
        return Answer(ACCEPTED, answer[4 : 8 - unused])
    data, toggle = b"", 0
    while True:
        answer = yield _segment(bytes([0x60 | toggle]) + bytes(SEGMENT_ROOM))
        if answer[0] & 0xF0 != toggle:
            return _result(answer, toggle)
        data += answer[1 : 8 - (answer[0] >> 1 & 7)]
        if answer[0] & LAST:
            return Answer(ACCEPTED, data)
        toggle ^= TOGGLE


def _initiate(head: int, address: Address, data: bytes) -> Request:
    named = multiplexer(address)
    return Request(bytes([head]) + named + data, lambda answer: answer[1:4] == named)


def _segment(data: bytes) -> Request:
    return Request(data, lambda answer: True)


def _segments(data: bytes) -> Iterator[bytes]:
    toggle = 0
    for start in range(0, len(data), SEGMENT_ROOM):
        part = data[start : start + SEGMENT_ROOM]
        last = LAST if start + SEGMENT_ROOM >= len(data) else 0
        head = toggle | SEGMENT_ROOM - len(part) << 1 | last
        yield bytes([head]) + part.ljust(SEGMENT_ROOM, b"\0")
        toggle ^= TOGGLE


def _result(answer: bytes, expected: int) -> Answer:
    if answer[0] == ABORT:
        return Answer(int.from_bytes(answer[4:8], "little"))
    if answer[0] == expected:
        return Answer(ACCEPTED)
    wrong_toggle = answer[0] ^ expected == TOGGLE
    return Answer(Abort.TOGGLE if wrong_toggle else Abort.COMMAND, by_client=True)
