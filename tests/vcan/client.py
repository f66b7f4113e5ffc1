"""A master with nothing in it but a raw socket: quick, and hard to confuse."""

import socket
import struct
import time

from tests.vcan.bus import CHANNEL

FRAME = struct.Struct("=IB3x8s")  # struct can_frame
PRE_OPERATIONAL = b"\x7f"
WHOLE_ID = 0xC00007FF  # with the flags that mark extended and remote frames


class Client:
    """Hears the SDO answers and the heartbeats of one node, and no other frame."""

    def __init__(self, node_id):
        self._node_id = node_id
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        filters = [struct.pack("=II", base + node_id, WHOLE_ID) for base in (0x580, 0x700)]
        self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"".join(filters))
        self._socket.bind((CHANNEL,))
        self.beats = []  # when a heartbeat of Pre-operational came

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self._socket.close()

    def ask(self, request, within=1.0):
        """The answer to a request given in hex, and the seconds it took; none if there is none."""
        data = bytes.fromhex(request).ljust(8, b"\0")
        begin = now = time.monotonic()
        self._socket.send(FRAME.pack(0x600 + self._node_id, 8, data))
        while now - begin < within:
            answer = self._hear(begin + within - now)
            now = time.monotonic()
            if answer is not None and answer[1:4] == data[1:4]:
                return answer.hex().upper(), now - begin
        return None, now - begin

    def _hear(self, within):
        """The next answer, none if it is a heartbeat or nothing at all."""
        self._socket.settimeout(max(within, 0.001))
        try:
            can_id, length, data = FRAME.unpack(self._socket.recv(FRAME.size))
        except TimeoutError:
            return None
        if can_id == 0x700 + self._node_id:
            if data[:length] == PRE_OPERATIONAL:
                self.beats.append(time.monotonic())
            return None
        return data[:length]
