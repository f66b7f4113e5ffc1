"""Frames as python-can has them; apart from `frame`, which is there without python-can."""

from typing import Any

import can

from canopen_twins.bus.frame import Frame


class Message(can.Message):
    """A message that is cheap to copy: python-can's virtual bus makes deep copies."""

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> can.Message:
        return message_of(frame_of(self))


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
