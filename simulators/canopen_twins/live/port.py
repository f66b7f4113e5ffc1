"""Where frames go in and out: a bus of python-can, or the CAN socket that python-can has opened.

What python-can does with a frame of socketcan (a `Message` with the time it came, four calls of the
system) costs more than the answer of a twin; of the socket itself one call is enough.
"""

import select
import socket
import struct
from contextlib import suppress

import can
from can.interfaces.socketcan import SocketcanBus

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import frame_of, message_of, receive

CAN_FRAME = struct.Struct("=IB3x8s")  # of linux/can.h: identifier with flags, length, data
EXTENDED, REMOTE, ERROR = 1 << 31, 1 << 30, 1 << 29  # flags of an identifier
STANDARD_ID, EXTENDED_ID = 0x7FF, 0x1FFF_FFFF
FD_SIZE = 72  # bytes of a frame of CAN FD
LONGEST_WAIT = 0.02  # seconds: the time-out that the socket has by itself
BACKLOG = 1 << 22  # bytes; by itself a socket keeps 250 frames, a busy bus brings them in 30 ms
SO_RCVBUFFORCE = 33  # of asm-generic/socket.h; only who may configure networks is granted it


class PythonCan:
    """Any bus of python-can."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus

    def send(self, frame: Frame) -> None:
        """Send; raises `CanError` or OSError if the bus fails."""
        self._bus.send(message_of(frame))

    def receive(self, seconds: float) -> Frame | None:
        """The next frame of classic CAN, none if there is none for so long; raises as `send`."""
        message = receive(self._bus, seconds)
        if message is None or message.is_error_frame or message.is_fd:
            return None
        return frame_of(message)


class CanSocket:
    """A raw CAN socket, which blocks; it is closed by whoever has opened it."""

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        microseconds = round(LONGEST_WAIT * 1e6)
        time_out = struct.pack("@ll", 0, microseconds)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, time_out)
        with suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, BACKLOG)

    def send(self, frame: Frame) -> None:
        """Send at once.

        Raises:
            OSError: the interface is down, or its queue is full.
        """
        can_id = frame.can_id | (EXTENDED if frame.extended else 0)
        if frame.remote:
            can_id |= REMOTE
        data = CAN_FRAME.pack(can_id, len(frame.data), frame.data)
        self._socket.send(data, socket.MSG_DONTWAIT)

    def receive(self, seconds: float) -> Frame | None:
        """The next frame of classic CAN, none if there is none for so long; raises as `send`."""
        if seconds != LONGEST_WAIT and not select.select([self._socket], [], [], seconds)[0]:
            return None
        try:
            data = self._socket.recv(FD_SIZE)
        except BlockingIOError:
            return None
        if len(data) != CAN_FRAME.size:
            return None
        can_id, length, payload = CAN_FRAME.unpack(data)
        if can_id & ERROR:
            return None
        remote, extended = bool(can_id & REMOTE), bool(can_id & EXTENDED)
        can_id &= EXTENDED_ID if extended else STANDARD_ID
        return Frame(can_id, b"" if remote else payload[:length], remote, extended)


def port(bus: can.BusABC) -> PythonCan | CanSocket:
    """The short way where there is one: on one interface, with nothing to filter."""
    if type(bus) is SocketcanBus and bus.channel and bus.filters is None:
        return CanSocket(bus.socket)
    return PythonCan(bus)
