"""SDO frames by the book: the bytes of CiA 301, 7.2.4.3, built and read."""

import pytest

from canopen_twins.bus import sdo
from canopen_twins.bus.sdo import Ccs, Scs, Sub

HEARTBEAT_TIME = 0x1017, 0
NAMED = bytes.fromhex("171000")


def test_an_object_is_named_by_three_bytes():
    assert sdo.multiplexer((0x1003, 0x0A)) == bytes.fromhex("03100a")
    assert sdo.address(bytes.fromhex("4003100a00000000")) == (0x1003, 0x0A)


@pytest.mark.parametrize(
    ("value", "frame"),
    [
        ("e8", "2f171000e8000000"),
        ("e803", "2b171000e8030000"),
        ("e80301", "27171000e8030100"),
        ("e8030102", "23171000e8030102"),
    ],
)
def test_up_to_four_bytes_go_in_one_frame(value, frame):
    value, frame = bytes.fromhex(value), bytes.fromhex(frame)
    assert sdo.expedited(Ccs.DOWNLOAD, NAMED, value) == frame
    answer = bytes([frame[0] + 0x20]) + frame[1:]
    assert sdo.expedited(Scs.UPLOAD, NAMED, value) == answer
    assert (sdo.size(frame), sdo.value(frame), sdo.is_expedited(frame)) == (len(value), value, True)


def test_an_initiate_may_leave_its_size_open():
    frame = sdo.expedited(Ccs.DOWNLOAD, NAMED, b"\1\2", sized=False)
    assert frame == bytes.fromhex("2217100001020000")
    assert (sdo.size(frame), sdo.value(frame)) == (None, b"\1\2\0\0")


def test_more_is_announced_and_comes_in_segments_with_a_toggle_bit():
    opening = sdo.announcing(Scs.UPLOAD, bytes.fromhex("081000"), 16)
    assert opening == bytes.fromhex("4108100010000000")
    assert (sdo.size(opening), sdo.is_expedited(opening)) == (16, False)
    frames = list(sdo.segments(b"canopen controls"))
    assert frames == [b"\x00canopen", b"\x10 contro", b"\x0bls\0\0\0\0\0"]
    assert b"".join(map(sdo.segment_part, frames)) == b"canopen controls"
    assert [bool(each[0] & sdo.LAST) for each in frames] == [False, False, True]


def test_nothing_is_one_segment():
    assert list(sdo.segments(b"")) == [b"\x0f" + bytes(7)]


@pytest.mark.parametrize(
    ("specifier", "command"),
    [
        (Ccs.UPLOAD, 0x40),
        (Ccs.UPLOAD_SEGMENT, 0x60),
        (Scs.DOWNLOAD, 0x60),
        (Scs.DOWNLOAD_SEGMENT, 0x20),
        (Ccs.ABORT, sdo.ABORT),
        (Scs.ABORT, sdo.ABORT),
    ],
)
def test_the_specifier_stands_in_the_upper_bits_of_the_command(specifier, command):
    frame = sdo.message(specifier, NAMED)
    assert frame == bytes([command]) + NAMED + bytes(4)
    assert sdo.specifier(frame) == specifier


def test_an_abort_names_its_object_and_its_code():
    frame = sdo.abort(NAMED, 0x0504_0000)
    assert frame == bytes.fromhex("8017100000000405")
    assert (sdo.is_abort(frame), sdo.abort_code(frame)) == (True, 0x0504_0000)


def test_the_last_segment_of_a_block_is_no_abort():
    frame = sdo.block_segment(b"abc", 0, 1)
    assert frame == b"\x81abc\0\0\0\0"
    assert (sdo.is_abort(frame), sdo.block_number(frame)) == (False, 1)


@pytest.mark.parametrize(("size", "head"), [(0, 0xDD), (1, 0xD9), (6, 0xC5), (7, 0xC1), (8, 0xD9)])
def test_the_end_of_blocks_tells_what_is_too_many(size, head):
    value = bytes(size)
    places = range(max(-(-size // 7), 1))
    received = b"".join(sdo.block_segment(value, place, place + 1)[1:] for place in places)
    end = sdo.block_end(Scs.BLOCK_UPLOAD, size, 0x31C3)
    assert end == bytes([head, 0xC3, 0x31]) + bytes(5)
    assert sdo.block_value(end, received) == value
    assert sdo.block_checksum(end) == 0x31C3


def test_the_checksum_of_blocks():
    assert sdo.crc(b"123456789") == 0x31C3  # CiA 301, 7.2.4.3.16


@pytest.mark.parametrize(
    ("specifier", "sub", "command"),
    [
        (Scs.BLOCK_DOWNLOAD, Sub.CONFIRM, 0xA2),
        (Scs.BLOCK_DOWNLOAD, Sub.END, 0xA1),
        (Ccs.BLOCK_UPLOAD, Sub.START, 0xA3),
        (Ccs.BLOCK_DOWNLOAD, Sub.END, 0xC1),
    ],
)
def test_the_sub_command_of_a_block_transfer_stands_in_the_lowest_bits(specifier, sub, command):
    assert sdo.message(specifier, flags=sub)[0] == command


def test_the_requests_that_open_a_transfer():
    opening = {Ccs.DOWNLOAD, Ccs.UPLOAD, Ccs.BLOCK_UPLOAD, Ccs.BLOCK_DOWNLOAD}
    assert {command >> 5 for command in sdo.INITIATES} == opening
    assert not {0x80, 0xA1, 0xA2, 0xA3, 0xC1} & sdo.INITIATES
