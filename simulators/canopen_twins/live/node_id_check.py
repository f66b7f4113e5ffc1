"""Listens, before twins go on a bus, whether somebody there has one of their node ids."""

import time
from collections.abc import Container, Iterable

import can

from canopen_twins.bus.identifiers import Cob, classify
from canopen_twins.bus.python_can import frame_of
from canopen_twins.errors import UserError
from canopen_twins.live.line import OpenBus

OWN = (Cob.EMCY, Cob.SDO_ANSWER, Cob.HEARTBEAT)  # what only the node itself sends


def looking(open_bus: OpenBus, node_ids: Iterable[int], seconds: float) -> OpenBus:
    """The same bus, which is listened to for some seconds when it is opened for the first time.

    Nothing is sent: a question by SDO would end a transfer that a master has under way. Whoever is
    silent for all that time is not found.

    Returns:
        Opens the bus; raises `UserError` if there is such a node.
    """
    wanted = frozenset(node_ids)
    left = [seconds]

    def open_and_look() -> can.BusABC:
        bus = open_bus()
        if left:
            try:
                _look(bus, wanted, left.pop())
            except BaseException:
                bus.shutdown()
                raise
        return bus

    return open_and_look


def _look(bus: can.BusABC, wanted: Container[int], seconds: float) -> None:
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        heard = bus.recv(left)
        if heard is None or heard.is_extended_id or heard.is_remote_frame or heard.is_error_frame:
            continue
        known = classify(heard.arbitration_id)
        if known is not None and known.cob in OWN and known.node_id in wanted:
            sent = frame_of(heard)
            raise UserError(f"node {known.node_id} is on the bus already: it has sent {sent}")
