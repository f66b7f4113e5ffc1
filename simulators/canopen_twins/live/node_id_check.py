"""Listens, before twins go on a bus, whether somebody there has one of their node ids."""

import time
from collections.abc import Iterable, Mapping

import can

from canopen_twins.bus.frame import Frame
from canopen_twins.errors import UserError
from canopen_twins.live.line import OpenBus

ANSWERS = (0x080, 0x580, 0x700)  # EMCY, SDO, heartbeat: what only the node itself sends


def looking(open_bus: OpenBus, node_ids: Iterable[int], seconds: float) -> OpenBus:
    """The same bus, which is listened to for some seconds when it is opened for the first time.

    Nothing is sent: a question by SDO would end a transfer that a master has under way. Whoever is
    silent for all that time is not found.

    Returns:
        Opens the bus; raises `UserError` if there is such a node.
    """
    senders = {base + node_id: node_id for base in ANSWERS for node_id in node_ids}
    left = [seconds]

    def open_and_look() -> can.BusABC:
        bus = open_bus()
        if left:
            try:
                _look(bus, senders, left.pop())
            except BaseException:
                bus.shutdown()
                raise
        return bus

    return open_and_look


def _look(bus: can.BusABC, senders: Mapping[int, int], seconds: float) -> None:
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        heard = bus.recv(left)
        if heard is None or heard.is_extended_id or heard.is_remote_frame or heard.is_error_frame:
            continue
        if (node_id := senders.get(heard.arbitration_id)) is not None:
            frame = Frame(heard.arbitration_id, bytes(heard.data))
            raise UserError(f"node {node_id} is on the bus already: it has sent {frame}")
