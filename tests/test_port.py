"""Frames as a CAN socket has them; a socket of another family stands in for one of vcan0."""

import socket
import struct

import can
import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.live.bus import steady
from canopen_twins.live.port import LONGEST_WAIT, CanSocket, PythonCan, port

AT_ONCE = 0.0


@pytest.fixture
def ends():
    ours, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    with ours, other:
        yield CanSocket(ours), other


def as_python_can_builds_it(text):
    """But for the byte that matters only in lengths above 8, in which it repeats the length."""
    can_id, data, remote, extended = Frame.parse(text)
    message = can.Message(
        arbitration_id=can_id, data=data, is_remote_frame=remote, is_extended_id=extended
    )
    data = can.interfaces.socketcan.socketcan.build_can_frame(message)
    return data[:7] + b"\0" + data[8:]


@pytest.mark.parametrize(
    "text", ["605#4000100000000000", "000#0105", "080#", "185#R", "1FFFFFFF#01", "00000605#R"]
)
def test_a_frame_goes_out_and_comes_in_as_python_can_has_it(ends, text):
    ours, other = ends
    ours.send(Frame.parse(text))
    assert other.recv(100) == as_python_can_builds_it(text)
    other.send(as_python_can_builds_it(text))
    assert ours.receive(AT_ONCE) == Frame.parse(text)


def test_the_length_that_a_remote_frame_asks_for_is_no_data(ends):
    ours, other = ends
    other.send(struct.pack("=IB3x8s", 0x185 | 1 << 30, 8, bytes(8)))
    assert ours.receive(AT_ONCE) == Frame.parse("185#R")


@pytest.mark.parametrize(
    "data",
    [struct.pack("=IB3x8s", 1 << 29 | 4, 8, bytes(8)), struct.pack("=IBB2x64s", 5, 9, 1, bytes(9))],
    ids=["error frame", "CAN FD"],
)
def test_what_is_no_frame_of_classic_can_is_left_out(ends, data):
    ours, other = ends
    other.send(data)
    other.send(as_python_can_builds_it("080#"))
    assert [ours.receive(AT_ONCE) for _ in range(2)] == [None, Frame.parse("080#")]


@pytest.mark.parametrize("wait", [0.0, 0.001, LONGEST_WAIT])
def test_without_a_frame_it_waits_as_long_as_it_is_told(ends, wait):
    begun = steady()
    assert ends[0].receive(wait) is None
    assert steady() - begun > 0.9 * wait


def test_a_queue_that_is_full_is_a_failure_of_the_bus_and_keeps_nobody_waiting(ends):
    def fill():
        for _ in range(100_000):
            ends[0].send(Frame.parse("080#"))

    with pytest.raises(OSError, match="unavailable"):
        fill()


def test_any_other_bus_is_that_of_python_can():
    with can.Bus("port", interface="virtual") as bus, can.Bus("port", interface="virtual") as other:
        ours = port(bus)
        assert isinstance(ours, PythonCan)
        ours.send(Frame.parse("705#00"))
        assert other.recv(30).arbitration_id == 0x705
        other.send(can.Message(arbitration_id=0x605, is_extended_id=False, data=[1]))
        assert ours.receive(1.0) == Frame.parse("605#01")
