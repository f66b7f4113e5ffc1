"""Frames in words, with the names of the dictionaries: for people who look at a trace."""

from collections.abc import Callable, Iterable, Iterator, Mapping

from canopen import SdoAbortedError

from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.slave.emcy import Emcy, emcy_of
from canopen_twins.slave.heartbeat import STATE_BYTE
from canopen_twins.slave.nmt import RESETS, TARGET
from canopen_twins.slave.object import Entry, Rejected
from canopen_twins.slave.pdo import Pdo
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo

COMMANDS: Mapping[int, str] = {
    **{command: state.lower() for command, state in TARGET.items()},
    **{command: f"reset {reset.name.lower()}" for command, reset in RESETS.items()},
}
STATES = {byte: state.lower() for state, byte in STATE_BYTE.items()}
ABORT = 0x80  # 81h and more: the last segment of a block
SERVICE, NODE_ID = 0x780, 0x7F

Words = Callable[[Frame, Slave | None], str]


class Decoder:
    """Knows the nodes of a bus; a frame of nobody it knows is told without names."""

    def __init__(self, nodes: Iterable[Node]) -> None:
        self._nodes = list(nodes)
        self._services: Mapping[int, Words] = {
            0x080: self._emcy,
            0x580: _sdo_answer,
            0x600: _sdo_request,
            0x700: _heartbeat,
        }

    def words(self, frame: Frame) -> str:
        """What a frame means, empty if nobody knows."""
        if frame.extended:
            return ""
        if frame.can_id == 0x000:
            return _nmt(frame)
        for slave, pdo in self._pdos():
            if pdo.cob_id == frame.can_id:
                return _pdo(frame, pdo, slave)
        if frame.can_id == 0x080:
            return "SYNC"
        service = self._services.get(frame.can_id & SERVICE)
        if service is None or frame.remote:
            return ""
        return service(frame, self._slave(frame.can_id & NODE_ID))

    def _slave(self, node_id: int) -> Slave | None:
        return next((node.slave for node in self._nodes if node.node_id == node_id), None)

    def _pdos(self) -> Iterator[tuple[Slave, Pdo]]:
        for slave in (node.slave for node in self._nodes):
            if slave is not None:
                for number in Tpdo.numbers(slave):
                    yield slave, Tpdo(slave, number)
                for number in Rpdo.numbers(slave):
                    yield slave, Rpdo(slave, number, lambda *_: None)

    def _emcy(self, frame: Frame, slave: Slave | None) -> str:
        told = emcy_of(frame.data)
        known = next(filter(told.is_like, self._active()), None)
        over = "one error less" if told.register else "no error left"
        label = known.label if known else "" if told.code else over
        return f"EMCY {told.code:04X}h register {told.register:02x}h {label}".strip()

    def _active(self) -> Iterator[Emcy]:
        for node in self._nodes:
            yield from node.device.emergencies
            yield from node.log.history


def _nmt(frame: Frame) -> str:
    if len(frame.data) < 2:
        return "NMT, too short"
    command, target = frame.data[:2]
    who = f"node {target}" if target else "all nodes"
    return f"NMT {COMMANDS.get(command, f'command {command:02X}h')}, {who}"


def _heartbeat(frame: Frame, slave: Slave | None) -> str:
    if len(frame.data) != 1:
        return ""
    return f"heartbeat {STATES.get(frame.data[0], '?')}" if frame.data[0] else "boot-up"


def _pdo(frame: Frame, pdo: Pdo, slave: Slave) -> str:
    name = f"{type(pdo).__name__.upper()}{pdo.number}"
    if frame.remote:
        return f"{name} requested"
    values = [
        f"{entry.variable.name} = {entry.unpack(frame.data[part])}"
        for entry, _, part in pdo.parts()
        if entry is not None and part.stop <= len(frame.data)
    ]
    return f"{name} {', '.join(values)}"


def _sdo_request(frame: Frame, slave: Slave | None) -> str:
    data = frame.data
    if len(data) != 8:
        return "SDO request, too short"
    kind = data[0] >> 5
    if data[0] == ABORT:
        return f"SDO abort by the client, {_abort(data)}"
    if kind == 1:
        return f"SDO write {_named(data, slave)}{_value(data, slave, data[0])}"
    if kind == 2:
        return f"SDO read {_named(data, slave)}"
    return {0: "SDO write segment", 3: "SDO read segment"}.get(kind, "SDO block transfer")


def _sdo_answer(frame: Frame, slave: Slave | None) -> str:
    data = frame.data
    kind = data[0] >> 5 if data else 7
    if data[:1] == bytes([ABORT]):
        return f"SDO abort {_named(data, slave)}, {_abort(data)}"
    if kind == 2:
        return f"SDO answer {_named(data, slave)}{_value(data, slave, data[0])}"
    if kind == 3:
        return f"SDO written {_named(data, slave)}"
    return "SDO segment"


def _abort(data: bytes) -> str:
    code = int.from_bytes(data[4:8], "little")
    return f"{code:08X}h {SdoAbortedError.CODES.get(code, '')}".strip()


def _named(data: bytes, slave: Slave | None) -> str:
    index, subindex = int.from_bytes(data[1:3], "little"), data[3]
    entry = _entry(data, slave)
    address = f"0x{index:04X}:{subindex:02X}"
    return f"{address} {entry.variable.qualname}" if entry else address


def _value(data: bytes, slave: Slave | None, command: int) -> str:
    """The value of an expedited transfer; its size is in the command, or that of the object."""
    entry = _entry(data, slave)
    if not command & 2:
        return " in segments"
    size = 4 - (command >> 2 & 3) if command & 1 else (entry.size if entry else None) or 4
    raw = data[4 : 4 + size]
    if entry is None or entry.size != size:
        return f" = {raw.hex(' ')}"
    return f" = {entry.unpack(raw)}"


def _entry(data: bytes, slave: Slave | None) -> Entry | None:
    if slave is None:
        return None
    try:
        return slave.entry(int.from_bytes(data[1:3], "little"), data[3])
    except Rejected:
        return None
