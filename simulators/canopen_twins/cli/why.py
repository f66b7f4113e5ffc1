"""why: what an object is, where its manual says so, and whether a device takes a value."""

import argparse
import struct
from collections.abc import Iterator

from canopen import SdoAbortedError, SdoCommunicationError
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import BOOLEAN, FLOAT_TYPES, INTEGER_TYPES, SIGNED_TYPES

from canopen_twins import devices
from canopen_twins.bench.bench import Bench
from canopen_twins.cli.command import OK, Parser, add_device, device_settings
from canopen_twins.device.node import wait_for_boot
from canopen_twins.diagnosis.sections import sections
from canopen_twins.errors import UserError
from canopen_twins.files.convert import convert
from canopen_twins.scenario.targets import Targets
from canopen_twins.slave.object import TYPES, Address, Entry

REFUSED = "refused with"
KINDS = {
    **dict.fromkeys(INTEGER_TYPES, int),
    **dict.fromkeys(FLOAT_TYPES, float),
    BOOLEAN: bool,
}
"""What a value is by its data type; a text otherwise."""


def add_why(parser: Parser) -> None:
    """why."""
    add_device(parser)
    text = "as `objects DEVICE` names it: 0x2014=7, 0x1018:02, 'Run command=1'"
    parser.add_argument("object", metavar="OBJECT[=VALUE]", help=text)
    parser.set_defaults(command=why)


def why(options: argparse.Namespace) -> int:
    """Name, type, access, limits and section; with a value what a device answers to its write."""
    told, equals, value = options.object.partition("=")
    device = devices.create(options.device, **device_settings(options))
    target = Targets(device.dictionary()).find(told.strip())
    assert target.variable is not None  # named raises
    lines = _described(target.variable)
    source = sections(device.eds).object(target.address)
    lines.append(f"source   {source or 'none: the device has no table of sections'}")
    if equals:
        for moment in ("after boot-up", "in operational"):
            bench = _booted(options)
            if moment == "in operational":
                bench.send(f"000#01{bench.twin.node.node_id:02X}")  # NMT: start
            lines.append(f"{value} {moment}: {_answer(bench, target.address, value.strip())}")
    elif target.variable.writable and target.variable.data_type in INTEGER_TYPES:
        lines += _refusals(_booted(options), target.address)
    print("\n".join(lines))
    return OK


def _described(variable: ODVariable) -> list[str]:
    return [
        f"object   0x{variable.index:04X}:{variable.subindex:02X} {variable.qualname}",
        f"type     {TYPES.get(variable.data_type or 0, '?')}",
        f"access   {variable.access_type}{', also by PDO' if variable.pdo_mappable else ''}",
        f"limits   {_limits(variable.min, variable.max)}",
    ]


def _limits(low: int | None, high: int | None) -> str:
    if low is None:
        return "those of its type" if high is None else f"at most {high}"
    return f"at least {low}" if high is None else f"{low}..{high}"


def _booted(options: argparse.Namespace) -> Bench:
    """One that nobody has done anything to.

    Raises:
        UserError: the device does not boot with these settings.
    """
    bench = Bench.of({options.device: devices.create(options.device, **device_settings(options))})
    if not wait_for_boot(bench.segment.nodes, bench.segment.advance):
        raise UserError(f"it does not boot: {bench.twin.node.device.silence or 'it is silent'}")
    return bench


def _refusals(bench: Bench, address: Address) -> Iterator[str]:
    """What the device says of the ends of the type that the limits let through: what it takes."""
    slave = bench.twin.node.slave
    assert slave is not None  # it has booted
    entry = slave.entry(*address)
    bits = 8 * (entry.size or 0)
    low, high = entry.variable.min, entry.variable.max
    signed = entry.variable.data_type in SIGNED_TYPES
    ends = [-1 << bits - 1] if signed and low is None else []
    ends += [(1 << bits - signed) - 1] if high is None else []
    for end in ends:
        answer = _answer(bench, address, str(end))
        if answer.startswith(REFUSED):
            yield f"takes    not all: {end} is {answer}"


def _answer(bench: Bench, address: Address, text: str) -> str:
    node = bench.twin.node
    assert node.slave is not None  # it has booted
    entry = node.slave.entry(*address)
    value = _value(entry, text)
    try:
        bench.twin.remote.sdo.download(*address, entry.pack(value))
    except SdoAbortedError as abort:
        notes = node.wire.events.refusals
        reason = notes[-1].words if notes else "no reason is known"
        return f"{REFUSED} {abort.code:#010x}: {reason}"
    except SdoCommunicationError:
        return f"not answered, the node is {node.state.lower()}"
    obstacle = entry.obstacle(value) if entry.obstacle and isinstance(value, int) else ""
    return f"accepted, without effect: {obstacle}" if obstacle else "accepted"


def _value(entry: Entry, text: str) -> object:
    """A value of the object's type.

    Raises:
        UserError: it is none.
    """
    data_type = entry.variable.data_type or 0
    value = convert(f"object {entry.variable.qualname!r}", text, KINDS.get(data_type, str))
    try:
        entry.pack(value)
    except (struct.error, ValueError, OverflowError):
        raise UserError(f"{text} does not fit {TYPES.get(data_type, 'the object')}") from None
    return value
