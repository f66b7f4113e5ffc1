"""What stands in the way of the values of objects, and how else a master could write them."""

import re
from collections.abc import Iterator, Sequence
from math import inf

from canopen_twins.bus.frame import Frame
from canopen_twins.diagnosis.view import View
from canopen_twins.slave import cob_id as cob_ids
from canopen_twins.slave.emcy import emcy_id
from canopen_twins.slave.nmt import ALL_NODES, TARGET
from canopen_twins.slave.object import Address, Entry, Rejected
from canopen_twins.slave.pdo import COB_ID, SYNCHRONOUS, TRANSMISSION_TYPE, carried
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.service import State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo


def values(view: View, slave: Slave, about: Sequence[Address], told: str) -> Iterator[str]:
    """What keeps a device from doing as its objects tell it, and where they are explained."""
    errors = [f"{each.code:04X}h {each.label}".strip() for each in view.node.log.active]
    if news := [each for each in errors if each.partition(" ")[2] not in told]:
        yield f"active: {', '.join(news)}"
    for obstacle, names in _obstacles(view, slave, about).items():
        if obstacle not in told:
            yield f"without effect now: {obstacle}, {', '.join(names)}"
    if sources := [view.named(each) for each in about if view.sections.object(each)]:
        yield f"see {', '.join(sources)}"


def _obstacles(view: View, slave: Slave, about: Sequence[Address]) -> dict[str, list[str]]:
    """The objects in whose way each of them stands."""
    obstacles: dict[str, list[str]] = {}
    for entries in slave.entries.values():
        for entry in entries.values():
            if obstacle := _obstacle(entry, about):
                obstacles.setdefault(obstacle, []).append(view.named(entry.address))
    return obstacles


def _obstacle(entry: Entry, about: Sequence[Address]) -> str:
    """In the way of the value that an object has; of one that nobody has set, only if asked."""
    if entry.obstacle is None:
        return ""
    try:
        data = entry.read()
    except Rejected:
        return ""
    told = data != entry.initial or entry.address in about
    return entry.obstacle(entry.unpack(data)) if told else ""


def ways(view: View, slave: Slave, about: Sequence[Address]) -> Iterator[str]:
    """How a master could have written objects, other than by SDO."""
    for number in Rpdo.numbers(slave):
        for entry, *_ in carried(slave, Rpdo.mapping + number - 1):
            if entry is not None and entry.address in about:
                record = Rpdo.communication + number - 1
                cob_id = slave.number(record, COB_ID)
                off = f", which is off: bit 31 of {view.named((record, COB_ID))} is set"
                way = f"RPDO{number}, {cob_id & cob_ids.CAN_ID:03X}h"
                yield f"{view.named(entry.address)} is in {way}" + (
                    off if cob_id & cob_ids.INVALID else ""
                )


COMMAND_LENGTH = 2


def sought(view: View, wanted: str, about: Sequence[Address], told: str = "") -> Iterator[str]:
    """What is known of it, in sentences; nothing while the node is silent.

    `wanted` is in words, as a scenario tells it; `about` are the objects it is about,
    and `told` is what has been said already.
    """
    slave = view.node.slave
    if slave is None:
        return
    if wanted.startswith("write "):
        yield from ways(view, slave, about)
    elif about and not wanted.startswith("no write "):
        yield from values(view, slave, about, told)
    elif wanted.startswith("state "):
        yield from _state(view, wanted.split()[1].upper())
    elif wanted.startswith("NMT "):
        yield from _others(view)
    elif wanted.startswith("no frame") and not wanted.startswith("no frame of"):
        yield from _spoke(view, slave)


def _commands(view: View) -> Iterator[Frame]:
    for record in view.records:
        frame = record.frame
        if frame.can_id == 0 and not frame.remote and len(frame.data) == COMMAND_LENGTH:
            yield frame


def _state(view: View, name: str) -> Iterator[str]:
    state = view.node.state
    if state == name:
        yield f"the node is {state.lower()}, and has not entered it anew"
        return
    known = {frame.data[0] for frame in _commands(view) if _is_for(view, frame)}
    commands = [command for command, target in TARGET.items() if target == name]
    if commands and not known.intersection(commands):
        yield (
            f"the node is {state.lower()}, and no NMT command {commands[0]:02X}h came for it"
            f"{view.service('nmt')}"
        )
    yield from _others(view)


def _is_for(view: View, frame: Frame) -> bool:
    return frame.data[1] in (ALL_NODES, view.node_id)


def _others(view: View) -> Iterator[str]:
    """NMT commands that were for somebody else."""
    for frame in _commands(view):
        if not _is_for(view, frame):
            yield f"{frame} is for node {frame.data[1]}, this is node {view.node_id}"


def _spoke(view: View, slave: Slave) -> Iterator[str]:
    """What made the node send its last frame."""
    own = [record for record in view.records if view.is_own(record)]
    if not own:
        return
    frame = own[-1].frame
    if frame.can_id == 0x700 + slave.node_id:
        yield _beat(view, slave, frame)
    elif frame.can_id == 0x580 + slave.node_id:
        yield f"{frame} answers a request{view.service('sdo')}"
    elif frame.can_id == emcy_id(slave):
        yield f"{frame} is an EMCY{view.service('emcy')}"
    for number in Tpdo.numbers(slave):
        record = Tpdo.communication + number - 1
        if slave.number(record, COB_ID) & cob_ids.CAN_ID == frame.can_id:
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


COB_ID_OF_FRAME = re.compile(r"([0-9A-F]{3})#")
ON_REQUEST = (252, 253)
OFF = -1  # the identifier of emergencies that are switched off


def silence(view: View) -> str:
    """Why the node is not on the bus; empty if it is."""
    node = view.node
    if not node.powered:
        return "the node is silent: its supply is off"
    if node.slave is None:
        reason = node.device.silence or "it has not booted"
        return f"the node is silent: {reason}{view.service('silence')}"
    if node.wire.shut:
        reason = node.device.silence or "it has shut itself off for a while"
        return f"the node is off the bus: {reason}{view.service('silence')}"
    return ""


def missing(view: View, wanted: str) -> str:
    """Why something that was waited for has not come; empty if nothing is known.

    `wanted` is in words, as a scenario tells it: it begins with a frame in the notation of
    cansend, with `EMCY` or with `heartbeat`.
    """
    slave = view.node.slave
    if slave is None:
        return ""
    can_id = _identifier(slave, wanted)
    return "" if can_id is None else _struck(view, can_id) or _frame(view, slave, can_id)


def _identifier(slave: Slave, wanted: str) -> int | None:
    if match := COB_ID_OF_FRAME.match(wanted):
        return int(match[1], 16)
    services = {"EMCY": emcy_id(slave) or OFF, "heartbeat": 0x700 + slave.node_id}
    return services.get(wanted.partition(" ")[0])


def _struck(view: View, can_id: int) -> str:
    """The last fault among the records that has struck such a frame."""
    begin = view.records[0].time if view.records else -inf
    for strike in reversed(view.strikes()):
        if strike.between(begin, inf) and strike.about.startswith(f"{can_id:03X}#"):
            return f"{strike.about} was sent: the fault {strike.fault}"
    return ""


def _frame(view: View, slave: Slave, can_id: int) -> str:
    for number in Tpdo.numbers(slave):
        record = Tpdo.communication + number - 1
        if slave.number(record, COB_ID) & cob_ids.CAN_ID == can_id:
            why = _tpdo(view, slave, number, record)
            return f"TPDO{number}: {why}" if why else ""
    if can_id == 0x700 + slave.node_id:
        return _heartbeat(view, slave)
    return _emcy(view, slave) if can_id == (emcy_id(slave) or OFF) else ""


def _tpdo(view: View, slave: Slave, number: int, record: int) -> str:
    state, kind = view.node.state, slave.number(record, TRANSMISSION_TYPE)
    if slave.number(record, COB_ID) & cob_ids.INVALID:
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


def _heartbeat(view: View, slave: Slave) -> str:
    if not slave.has(0x1017):
        return f"there is no heartbeat, nor an object 0x1017{view.service('heartbeat')}"
    if slave.number(0x1017):
        return ""
    return f"there is no heartbeat: {view.named((0x1017, 0))} is 0"


def _emcy(view: View, slave: Slave) -> str:
    if view.node.state is State.STOPPED:
        return f"no EMCY: the node is stopped{view.service('states')}"
    if emcy_id(slave) is None:
        return f"no EMCY: bit 31 of {view.named((0x1014, 0))} is set"
    told = ", ".join(f"{emcy.code:04X}h {emcy.label}".strip() for emcy in view.node.log.active)
    if not told:
        return f"no error is active{view.service('emcy')}"
    return f"active, and told when they came: {told}{view.service('emcy')}"
