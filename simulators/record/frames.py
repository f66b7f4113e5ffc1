"""The frames of a record or of a trace file, one after the other."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import can
from can.io.player import MESSAGE_READERS

from simulators.clock import microseconds
from simulators.errors import UserError
from simulators.wire import Frame


class Sent(NamedTuple):
    """A frame and its moment."""

    tick: int
    """Microseconds."""
    frame: Frame


def read_frames(path: Path) -> Iterator[Sent]:
    """What a trace file of any format of python-can holds; error frames are left out.

    Raises:
        UserError: it is no trace file, or it cannot be read; only when the frames are taken.
    """
    suffixes = [suffix.lower() for suffix in path.suffixes if suffix != ".gz"]
    if not suffixes or suffixes[-1] not in MESSAGE_READERS:
        raise UserError(f"{path} is no trace file: its name ends in {', '.join(MESSAGE_READERS)}")
    if not path.is_file():
        raise UserError(f"{path} is not there")
    try:
        with can.LogReader(path) as reader:
            yield from map(_sent, (each for each in reader if not each.is_error_frame))
    except Exception as damage:  # whatever a reader of python-can stumbles over
        reason = str(damage) or type(damage).__name__
        raise UserError(f"{path} cannot be read as {suffixes[-1]}: {reason}") from damage


def _sent(message: can.Message) -> Sent:
    remote, extended = message.is_remote_frame, message.is_extended_id
    frame = Frame(message.arbitration_id, bytes(message.data), remote, extended)
    return Sent(microseconds(message.timestamp), frame)
