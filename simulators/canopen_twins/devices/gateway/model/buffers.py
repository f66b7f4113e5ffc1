"""Buffers of the gateway: they overflow if more comes than it can serve (7.2.1, 7.2.2, A-60)."""

from collections.abc import Mapping
from enum import Enum

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.state import Trouble


class Buffer(Enum):
    """Buffers of the gateway that can overflow (7.2.1, 7.2.2, A-09)."""

    CAN1_RECEIVE = "CANopen data from the governor"
    CAN2_RECEIVE = "frames from the CANopen bus"
    SDO_TRANSMIT = "SDO answers"


OVERFLOW: Mapping[Buffer, tuple[int, Trouble]] = {
    Buffer.CAN1_RECEIVE: (errors.CAN_COMM_1, Trouble.ABORT),
    Buffer.CAN2_RECEIVE: (errors.CAN_COMM_2, Trouble.ABORT),
    Buffer.SDO_TRANSMIT: (errors.CAN_COMM_2, Trouble.SDO_OVERFLOW),
}
RECEIVE_ROOM = 64  # PDOs and heartbeats in one main cycle


class ReceiveBuffer:
    """Frames of the CANopen bus that wait for the main cycle; an ideal one has room for all."""

    def __init__(self, *, ideal: bool) -> None:
        self._ideal = ideal
        self._received = 0

    def clear(self) -> None:
        """It is empty: a main cycle has taken all, or it has overflowed."""
        self._received = 0

    def receive(self) -> bool:
        """A PDO or a heartbeat comes; whether it finds no room."""
        self._received += 1
        return not self._ideal and self._received > RECEIVE_ROOM
