"""Why a node says nothing at all, or not what somebody waits for."""

import re
from math import inf

from simulators.objects import Rejected
from simulators.services import State
from simulators.services import cob_id as cob_ids
from simulators.services.emcy import emcy_id
from simulators.services.mapping import mapped
from simulators.services.pdo import COB_ID, SYNCHRONOUS, TRANSMISSION_TYPE
from simulators.services.tpdo import Tpdo
from simulators.slave import Slave
from simulators.why.view import View

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
    if not _carries(slave, Tpdo.mapping + number - 1):
        return f"nothing is mapped in {view.named((Tpdo.mapping + number - 1, 0))}"
    if kind in ON_REQUEST:
        return f"it comes on a remote request, {view.named((record, TRANSMISSION_TYPE))} is {kind}"
    if kind in SYNCHRONOUS:
        return f"it comes with a SYNC, {view.named((record, TRANSMISSION_TYPE))} is {kind}"
    return f"it has its own moments{view.service('pdo')}"


def _carries(slave: Slave, mapping: int) -> bool:
    try:
        return bool(mapped(slave, mapping))
    except Rejected:
        return False


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
