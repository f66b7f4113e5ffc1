"""What was expected in vain, as an object, and what is known of why it did not come."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import CAN_ID, INVALID
from canopen_twins.diagnosis.view import View
from canopen_twins.slave.emcy import emcy_id
from canopen_twins.slave.nmt import ALL_NODES, TARGET
from canopen_twins.slave.object import Address, Entry, Rejected
from canopen_twins.slave.pdo import COB_ID, SYNCHRONOUS, TRANSMISSION_TYPE, carried
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.service import State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo

ON_REQUEST = (252, 253)  # transmission types
COMMAND_LENGTH = 2


class Expected:
    """Something that was waited for at a node; who knows nothing of it has no sentences."""

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """What is known of it, in sentences; `told` is what has been said already."""
        raise NotImplementedError


# Frames that have not come


@dataclass(frozen=True)
class ExpectedFrame(Expected):
    """A frame of an identifier: what has struck the last one, or why its service sends none."""

    can_id: int

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """At most one."""
        if reason := _struck(view, self.can_id) or _not_sent(view, slave, self.can_id):
            yield reason


class ExpectedEmcy(Expected):
    """Any emergency of the node."""

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """As for a frame, whatever its identifier is."""
        can_id = emcy_id(slave)
        yield (can_id is not None and _struck(view, can_id)) or _no_emcy(view, slave)


class ExpectedHeartbeat(Expected):
    """Any heartbeat of the node."""

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """As for a frame."""
        yield from ExpectedFrame(identifiers.heartbeat(slave.node_id)).reasons(view, slave, told)


def _struck(view: View, can_id: int) -> str:
    """The last fault among the records that has struck such a frame."""
    begin = view.records[0].time if view.records else -inf
    for strike in reversed(view.strikes()):
        if strike.between(begin, inf) and strike.about.startswith(f"{can_id:03X}#"):
            return f"{strike.about} was sent: the fault {strike.fault}"
    return ""


def _not_sent(view: View, slave: Slave, can_id: int) -> str:
    """Why a service is silent; empty if it is not, or if it is none of ours."""
    for number in Tpdo.numbers(slave):
        record = Tpdo.communication + number - 1
        if slave.number(record, COB_ID) & CAN_ID == can_id:
            return f"TPDO{number}: {_no_tpdo(view, slave, number, record)}"
    if can_id == identifiers.heartbeat(slave.node_id):
        return _no_heartbeat(view, slave)
    return _no_emcy(view, slave) if can_id == emcy_id(slave) else ""


def _no_tpdo(view: View, slave: Slave, number: int, record: int) -> str:
    state, kind = view.node.state, slave.number(record, TRANSMISSION_TYPE)
    if slave.number(record, COB_ID) & INVALID:
        return f"it is off, bit 31 of {view.named((record, COB_ID))} is set"
    if state not in Tpdo.active_in:
        return f"the node is {state.lower()}, without PDO{view.service('states')}"
    if not carried(slave, Tpdo.mapping + number - 1):
        return f"nothing is mapped in {view.named((Tpdo.mapping + number - 1, 0))}"
    if kind in ON_REQUEST:
        return f"it comes on a remote request, {view.named((record, TRANSMISSION_TYPE))} is {kind}"
    if kind in SYNCHRONOUS:
        return f"it comes with a SYNC, {view.named((record, TRANSMISSION_TYPE))} is {kind}"
    return f"it has its own moments{view.service('pdo')}"


def _no_heartbeat(view: View, slave: Slave) -> str:
    if not slave.has(0x1017):
        return f"there is no heartbeat, nor an object 0x1017{view.service('heartbeat')}"
    if slave.number(0x1017):
        return ""
    return f"there is no heartbeat: {view.named((0x1017, 0))} is 0"


def _no_emcy(view: View, slave: Slave) -> str:
    if view.node.state is State.STOPPED:
        return f"no EMCY: the node is stopped{view.service('states')}"
    if emcy_id(slave) is None:
        return f"no EMCY: bit 31 of {view.named((0x1014, 0))} is set"
    told = ", ".join(f"{emcy.code:04X}h {emcy.label}".strip() for emcy in view.node.log.active)
    if not told:
        return f"no error is active{view.service('emcy')}"
    return f"active, and told when they came: {told}{view.service('emcy')}"


# A silence that was not kept


class ExpectedSilence(Expected):
    """No frame of the node at all."""

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """What made the node send its last frame."""
        own = [record for record in view.records if view.is_own(record)]
        if not own:
            return
        frame = own[-1].frame
        if frame.can_id == identifiers.heartbeat(slave.node_id):
            yield _beat(view, slave, frame)
        elif frame.can_id == identifiers.sdo_answer(slave.node_id):
            yield f"{frame} answers a request{view.service('sdo')}"
        elif frame.can_id == emcy_id(slave):
            yield f"{frame} is an EMCY{view.service('emcy')}"
        for number in Tpdo.numbers(slave):
            record = Tpdo.communication + number - 1
            if slave.number(record, COB_ID) & CAN_ID == frame.can_id:
                kind = slave.number(record, TRANSMISSION_TYPE)
                named = view.named((record, TRANSMISSION_TYPE))
                yield f"{frame} is TPDO{number}: {named} is {kind}"


def _beat(view: View, slave: Slave, frame: Frame) -> str:
    if frame.data == b"\0":
        return f"{frame} is a boot-up{view.service('nmt')}"
    if not slave.has(0x1017):
        return f"{frame} is a heartbeat{view.service('heartbeat')}"
    period = slave.number(0x1017)
    return f"{frame} is a heartbeat: {view.named((0x1017, 0))} is {period} ms"


# NMT


@dataclass(frozen=True)
class ExpectedState(Expected):
    """That the node enters an NMT state."""

    state: State

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """Whether it is there already, and the command that is missing."""
        state = view.node.state
        if state == self.state:
            yield f"the node is {state.lower()}, and has not entered it anew"
            return
        known = {frame.data[0] for frame in _commands(view) if _is_for(view, frame)}
        commands = [command for command, target in TARGET.items() if target is self.state]
        if commands and not known.intersection(commands):
            yield (
                f"the node is {state.lower()}, and no NMT command {commands[0]:02X}h came for it"
                f"{view.service('nmt')}"
            )
        yield from _for_others(view)


class ExpectedCommand(Expected):
    """An NMT command for the node."""

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """Those that were for somebody else."""
        yield from _for_others(view)


def _commands(view: View) -> Iterator[Frame]:
    for record in view.records:
        frame = record.frame
        is_nmt = frame.can_id == identifiers.NMT and not frame.remote
        if is_nmt and len(frame.data) == COMMAND_LENGTH:
            yield frame


def _is_for(view: View, frame: Frame) -> bool:
    return frame.data[1] in (ALL_NODES, view.node_id)


def _for_others(view: View) -> Iterator[str]:
    for frame in _commands(view):
        if not _is_for(view, frame):
            yield f"{frame} is for node {frame.data[1]}, this is node {view.node_id}"


# Objects


@dataclass(frozen=True)
class ExpectedWrites(Expected):
    """That the master writes objects."""

    objects: Sequence[Address]

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """How it could have, other than by SDO."""
        for number in Rpdo.numbers(slave):
            for entry, *_ in carried(slave, Rpdo.mapping + number - 1):
                if entry is not None and entry.address in self.objects:
                    record = Rpdo.communication + number - 1
                    cob_id = slave.number(record, COB_ID)
                    off = f", which is off: bit 31 of {view.named((record, COB_ID))} is set"
                    yield (
                        f"{view.named(entry.address)} is in RPDO{number}, {cob_id & CAN_ID:03X}h"
                        f"{off if cob_id & INVALID else ''}"
                    )


@dataclass(frozen=True)
class ExpectedValues(Expected):
    """Values of objects, whichever they should have, or should not."""

    objects: Sequence[Address]

    def reasons(self, view: View, slave: Slave, told: str) -> Iterator[str]:
        """What keeps the device from doing as its objects tell it, and where they are explained."""
        errors = [f"{each.code:04X}h {each.label}".strip() for each in view.node.log.active]
        if news := [each for each in errors if each.partition(" ")[2] not in told]:
            yield f"active: {', '.join(news)}"
        for obstacle, names in self._obstacles(view, slave).items():
            if obstacle not in told:
                yield f"without effect now: {obstacle}, {', '.join(names)}"
        if sources := [view.named(each) for each in self.objects if view.sections.object(each)]:
            yield f"see {', '.join(sources)}"

    def _obstacles(self, view: View, slave: Slave) -> dict[str, list[str]]:
        """The objects in whose way each of them stands."""
        obstacles: dict[str, list[str]] = {}
        for entries in slave.entries.values():
            for entry in entries.values():
                if obstacle := self._obstacle(entry):
                    obstacles.setdefault(obstacle, []).append(view.named(entry.address))
        return obstacles

    def _obstacle(self, entry: Entry) -> str:
        """In the way of the value that an object has; of one that nobody has set, only if asked."""
        if entry.obstacle is None:
            return ""
        try:
            data = entry.read()
        except Rejected:
            return ""
        asked = data != entry.initial or entry.address in self.objects
        return entry.obstacle(entry.unpack(data)) if asked else ""
