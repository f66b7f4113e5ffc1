"""Frames as python-can has them; apart from `frame`, which is there without python-can."""

from typing import Any

import can

from canopen_twins.bus.frame import Frame


class Message(can.Message):
    """A message that is cheap to copy: python-can's virtual bus makes deep copies."""

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> can.Message:
        return Message(
            arbitration_id=self.arbitration_id,
            is_extended_id=self.is_extended_id,
            is_remote_frame=self.is_remote_frame,
            data=bytearray(self.data),  # it takes one as it is
        )


def message_of(frame: Frame, **more: Any) -> Message:
    """A frame for a bus or a file of python-can; `more` is what it knows besides, as its time."""
    return Message(
        arbitration_id=frame.can_id,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        data=frame.data,
        **more,
    )


def frame_of(message: can.Message) -> Frame:
    """The frame of a message of classic CAN."""
    remote, extended = message.is_remote_frame, message.is_extended_id
    return Frame(message.arbitration_id, bytes(message.data), remote, extended)


def receive(bus: can.BusABC, seconds: float) -> can.Message | None:
    """The next message of a bus, none if there is none for so long.

    `can.BusABC.recv` counts with the clock on the wall: set back by an hour, it would wait for an
    hour. What its interface does by itself waits for so long and no longer.
    """
    if type(bus).recv is not can.BusABC.recv:
        return bus.recv(seconds)
    message, filtered = bus._recv_internal(seconds)  # noqa: SLF001
    if message is None or filtered or bus._matches_filters(message):  # noqa: SLF001
        return message
    return None
