"""Frames in words, with the names of the dictionaries: for people who look at a trace."""

from collections.abc import Callable, Iterable, Iterator, Mapping

from canopen import SdoAbortedError

from canopen_twins.bus import sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import Cob, classify
from canopen_twins.bus.sdo import Ccs, Scs
from canopen_twins.device.node import Node
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.emcy import Emcy, emcy_of
from canopen_twins.slave.error_control import TOGGLE
from canopen_twins.slave.nmt import RESETS, STATE_BYTE, TARGET
from canopen_twins.slave.object import Entry, Rejected
from canopen_twins.slave.pdo import Pdo, carried
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo

COMMANDS: Mapping[int, str] = {
    **{command: state.lower() for command, state in TARGET.items()},
    **{command: f"reset {reset.name.lower()}" for command, reset in RESETS.items()},
}
SEGMENTS: Mapping[int, str] = {
    Ccs.DOWNLOAD_SEGMENT: "write segment",
    Ccs.UPLOAD_SEGMENT: "read segment",
}
STATES = {byte: state.lower() for state, byte in STATE_BYTE.items()}

Words = Callable[[Frame, Slave | None], str]


class Decoder:
    """Knows the nodes of a bus; a frame of nobody it knows is told without names."""

    def __init__(self, nodes: Iterable[Node]) -> None:
        self._nodes = list(nodes)
        self._known: list[tuple[Slave, int]] = []  # whose PDOs have been looked up, and when
        self._pdos: dict[int, tuple[Slave, type[Pdo], int]] = {}
        self._services: Mapping[Cob, Words] = {
            Cob.NMT: _nmt,
            Cob.SYNC: lambda *_: "SYNC",
            Cob.EMCY: self._emcy,
            Cob.SDO_ANSWER: _sdo_answer,
            Cob.SDO_REQUEST: _sdo_request,
            Cob.HEARTBEAT: _heartbeat,
        }

    def words(self, frame: Frame) -> str:
        """What a frame means, empty if nobody knows."""
        if frame.extended:
            return ""
        if (pdo := self._pdo(frame.can_id)) is not None:
            return _pdo(frame, *pdo)
        known = classify(frame.can_id)
        if known is None or frame.remote:
            return ""
        words = self._services.get(known.cob)
        return words(frame, self._slave(known.node_id)) if words is not None else ""

    def _slave(self, node_id: int) -> Slave | None:
        return next((node.slave for node in self._nodes if node.node_id == node_id), None)

    def _pdo(self, can_id: int) -> tuple[Slave, type[Pdo], int] | None:
        """The first PDO with an identifier; looked up anew if a communication area has changed."""
        slaves = [node.slave for node in self._nodes]
        known = [(slave, slave.changes) for slave in slaves if slave is not None]
        if known != self._known:
            self._known, self._pdos = known, {}
            for slave, _ in known:
                for kind in (Tpdo, Rpdo):
                    for number in kind.numbers(slave):
                        if (identifier := kind.identifier(slave, number)) is not None:
                            self._pdos.setdefault(identifier, (slave, kind, number))
        return self._pdos.get(can_id)

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


def _nmt(frame: Frame, slave: Slave | None) -> str:
    if len(frame.data) < 2:
        return "NMT, too short"
    command, target = frame.data[:2]
    who = f"node {target}" if target else "all nodes"
    return f"NMT {COMMANDS.get(command, f'command {command:02X}h')}, {who}"


def _heartbeat(frame: Frame, slave: Slave | None) -> str:
    if len(frame.data) != 1:
        return ""
    state = frame.data[0] & ~TOGGLE  # of an answer to node guarding
    return f"heartbeat {STATES.get(state, '?')}" if frame.data[0] else "boot-up"


def _pdo(frame: Frame, slave: Slave, kind: type[Pdo], number: int) -> str:
    name = f"{kind.__name__.upper()}{number}"
    if frame.remote:
        return f"{name} requested"
    values = [
        f"{part.entry.variable.name} = {part.entry.unpack(part.value(frame.data))}"
        for part in carried(slave, kind.mapping + number - 1)
        if part.entry is not None and part.end <= 8 * len(frame.data)
    ]
    return f"{name} {', '.join(values)}"


def _sdo_request(frame: Frame, slave: Slave | None) -> str:
    data = frame.data
    if len(data) != sdo.LENGTH:
        return "SDO request, too short"
    if sdo.is_abort(data):
        return f"SDO abort by the client, {_abort(data)}"
    specifier = sdo.specifier(data)
    if specifier == Ccs.DOWNLOAD:
        return f"SDO write {_named(data, slave)}{_value(data, slave)}"
    if specifier == Ccs.UPLOAD:
        return f"SDO read {_named(data, slave)}"
    return f"SDO {SEGMENTS.get(specifier, 'block transfer')}"


def _sdo_answer(frame: Frame, slave: Slave | None) -> str:
    data = frame.data
    if len(data) != sdo.LENGTH:
        return "SDO answer, too short"
    if sdo.is_abort(data):
        return f"SDO abort {_named(data, slave)}, {_abort(data)}"
    match sdo.specifier(data):
        case Scs.UPLOAD:
            return f"SDO answer {_named(data, slave)}{_value(data, slave)}"
        case Scs.DOWNLOAD:
            return f"SDO written {_named(data, slave)}"
    return "SDO segment"


def _abort(data: bytes) -> str:
    code = sdo.abort_code(data)
    return f"{code:08X}h {SdoAbortedError.CODES.get(code, '')}".strip()


def _named(data: bytes, slave: Slave | None) -> str:
    entry, address = _entry(data, slave), address_text(sdo.address(data))
    return f"{address} {entry.variable.qualname}" if entry else address


def _value(data: bytes, slave: Slave | None) -> str:
    """The value of an expedited transfer; its size is told, or that of the object."""
    if not sdo.is_expedited(data):
        return " in segments"
    entry, raw = _entry(data, slave), sdo.value(data)
    if entry is not None and sdo.size(data) is None:
        raw = raw[: entry.size]
    if entry is None or entry.size != len(raw):
        return f" = {raw.hex(' ')}"
    return f" = {entry.unpack(raw)}"


def _entry(data: bytes, slave: Slave | None) -> Entry | None:
    if slave is None:
        return None
    try:
        return slave.entry(*sdo.address(data))
    except Rejected:
        return None
