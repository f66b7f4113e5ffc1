"""What the master writes to one node: SDO downloads and RPDOs, as seen from the bus."""

from collections.abc import Iterator, Mapping

from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.scenario.matchers import Sent, Wrote
from canopen_twins.scenario.player.downloads import Downloads
from canopen_twins.slave.cob_id import CAN_ID, INVALID
from canopen_twins.slave.object import Address
from canopen_twins.slave.pdo import COB_ID, carried
from canopen_twins.slave.slave import Slave

REQUEST_LENGTH = 8
COMMUNICATION, MAPPING = range(0x1400, 0x1600), 0x0200  # and the distance to its mapping record

Slices = list[tuple[Address, slice]]


class Writes:
    """Follows requests and RPDOs in every NMT state; while the node is silent, requests alone."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._downloads = Downloads()
        self._version: tuple[Slave, int] | None = None
        self._rpdos: Mapping[int, Slices] = {}

    def follow(self, sent: Sent) -> Iterator[Wrote]:
        """Take a frame; what has been written with it."""
        frame, node = sent.frame, self._node
        if frame.remote or frame.extended:
            return
        if sent.node is node:
            if frame.can_id == 0x580 + node.node_id and len(frame.data) == REQUEST_LENGTH:
                self._downloads.answer(frame.data)
        elif sent.node is None and frame.can_id == 0x600 + node.node_id:
            if len(frame.data) == REQUEST_LENGTH:
                for address, data, sized in self._downloads.ask(frame.data):
                    yield Wrote(node, address, data, sized)
        elif sent.node is None:
            yield from self._mapped(frame)

    def _mapped(self, frame: Frame) -> Iterator[Wrote]:
        self._refresh()
        for address, part in self._rpdos.get(frame.can_id, ()):
            if part.stop <= len(frame.data):
                yield Wrote(self._node, address, frame.data[part])

    def _refresh(self) -> None:
        slave = self._node.slave
        version = None if slave is None else (slave, slave.changes)
        if version != self._version:
            self._version = version
            self._rpdos = {} if slave is None else _rpdos(slave)


def _rpdos(slave: Slave) -> Mapping[int, Slices]:
    """What every RPDO that is on brings, by its identifier."""
    rpdos: dict[int, Slices] = {}
    for index in COMMUNICATION:
        if slave.has(index, COB_ID) and slave.has(index + MAPPING):
            value = slave.number(index, COB_ID)
            if not value & INVALID:
                rpdos.setdefault(value & CAN_ID, []).extend(_slices(slave, index + MAPPING))
    return rpdos


def _slices(slave: Slave, index: int) -> Slices:
    return [(entry.address, part) for entry, _, part in carried(slave, index) if entry is not None]
