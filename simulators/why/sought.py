"""Why something that a master or a node should have done, or left, has come to be otherwise."""

from collections.abc import Iterator, Sequence

from simulators.frame import Frame
from simulators.objects import Address
from simulators.services import cob_id as cob_ids
from simulators.services.emcy import emcy_id
from simulators.services.nmt import ALL_NODES, TARGET
from simulators.services.pdo import COB_ID, TRANSMISSION_TYPE
from simulators.services.tpdo import Tpdo
from simulators.slave import Slave
from simulators.why.values import values, ways
from simulators.why.view import View

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
