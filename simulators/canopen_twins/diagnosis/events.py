"""Emergencies, and what a node did not obey: NMT commands that are none."""

from collections.abc import Iterator

from canopen_twins.bus.frame import Frame
from canopen_twins.diagnosis.view import Line, View, in_brackets
from canopen_twins.slave.emcy import Emcy, emcy_id, emcy_of
from canopen_twins.slave.nmt import ALL_NODES, RESETS, TARGET, Nmt


def emergencies(view: View) -> Iterator[Line]:
    """What every emergency of the node is about; the end of an error needs no reason."""
    slave = view.node.slave
    can_id = None if slave is None else emcy_id(slave)
    for record in view.records:
        is_emcy = view.is_own(record) and record.frame.can_id == can_id
        if is_emcy and (text := _emergency(view, record.frame.data)):
            yield Line(record, text)


def _emergency(view: View, data: bytes) -> str:
    told = emcy_of(data)
    meaning = _meaning(view, told) if told.code else ""
    return f"EMCY {told.code:04X}h detail {told.detail:X}h: {meaning}" if meaning else ""


def _meaning(view: View, told: Emcy) -> str:
    """Its label and its section; empty if nobody knows it."""
    known = [*view.node.device.emergencies, *view.node.log.history]
    label = next((emcy.label for emcy in known if told.is_like(emcy)), "")
    return f"{label}{in_brackets(view.sections.emcy(told.code))}".strip()


def commands(view: View) -> Iterator[Line]:
    """NMT commands that had no effect, and why."""
    for record in view.records:
        is_nmt = record.frame.can_id == 0x000 and not record.frame.remote
        if is_nmt and (text := _command(view, record.frame, record.time)):
            yield Line(record, f"{record.frame} not obeyed: {text}")


def _command(view: View, frame: Frame, time: float) -> str:
    if len(frame.data) not in view.node.device.profile.nmt_lengths:
        return f"an NMT command has 2 bytes, not {len(frame.data)}{view.service('nmt')}"
    command, target = frame.data[:2]
    if target not in (ALL_NODES, view.node_id):
        return ""
    if command not in {*TARGET, *RESETS}:
        return f"there is no command {command:02X}h{view.service('nmt')}"
    return "" if view.may(time, Nmt.active_in) else view.unable(time, Nmt.active_in, "NMT")
