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
SDO_ROOM = 32  # answers that wait
RECEIVE_ROOM = 64  # PDOs and heartbeats in one main cycle


class Buffers:
    """How full they are; one that takes no time for an answer is never behind."""

    def __init__(self, answer_time: int) -> None:
        self._answer_time = answer_time  # us
        self._busy_until = 0
        self._received = 0

    def clear(self) -> None:
        """All of them are cleared."""
        self._busy_until = self._received = 0

    def begin_cycle(self) -> None:
        """A main cycle has taken what was received."""
        self._received = 0

    def ask(self, now: int) -> bool:
        """An SDO request comes; whether its answer finds no room."""
        if not self._answer_time:
            return False
        self._busy_until = max(now, self._busy_until) + self._answer_time
        return self._busy_until - now > SDO_ROOM * self._answer_time

    def receive(self) -> bool:
        """A PDO or a heartbeat comes; whether it finds no room."""
        self._received += 1
        return self._answer_time > 0 and self._received > RECEIVE_ROOM
