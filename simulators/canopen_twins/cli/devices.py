"""list, eds, objects, settings: the devices there are, and what their files say."""

import argparse
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from typing import Any

from canopen.objectdictionary import ODVariable

from canopen_twins import devices
from canopen_twins.cli.command import DEVICE, OK, Parser, add_device, device_settings
from canopen_twins.device.dcf import dcf
from canopen_twins.device.device import Device
from canopen_twins.device.settings import about
from canopen_twins.errors import UserError
from canopen_twins.files.shipped import od_file, scenarios
from canopen_twins.slave.object import TYPES

NAME = re.compile(r"^name: (.+)$", re.MULTILINE)


def add_list(parser: Parser) -> None:
    """list."""
    text = "only the scenarios of this one"
    parser.add_argument("device", metavar="DEVICE", nargs="?", help=text)
    parser.set_defaults(command=list_all)


def list_all(options: argparse.Namespace) -> int:
    """The devices, then their scenarios with their names, or those of one device alone."""
    if options.device:
        devices.find(options.device)
        _table(_stories(options.device))
        return OK
    _table(_devices())
    for device in devices.names():
        if stories := list(_stories(device)):
            print()
            _table(stories)
    return OK


def add_objects(parser: Parser) -> None:
    """objects."""
    parser.add_argument("device", metavar="DEVICE", help=DEVICE)
    parser.set_defaults(command=objects)


def objects(options: argparse.Namespace) -> int:
    """Every entry of the object dictionary; defaults that depend on the node id are those of 1."""
    device = devices.create(options.device)
    _table([("object", "name", "type", "access", "default", "limits"), *_entries(device)])
    return OK


def add_settings(parser: Parser) -> None:
    """settings."""
    parser.add_argument("device", metavar="DEVICE", help=DEVICE)
    parser.set_defaults(command=settings)


def settings(options: argparse.Namespace) -> int:
    """Every setting with its default; A-numbers are explained in the device's page of the docs."""
    rows = [("setting", "default", "assumed", "meaning")]
    delivered = devices.find(options.device).settings
    for entry in fields(delivered):
        told = about(entry)
        unit = f" [{told.unit}]" if told.unit else ""
        within = f", {told.range}" if told.range else ""
        live = "; may change while running" if told.live else ""
        value = getattr(delivered, entry.name)
        default = value if isinstance(value, str) else str(value).lower()
        rows.append((entry.name, default, told.assumed, f"{told.text}{unit}{within}{live}"))
    _table(rows)
    return OK


def add_eds(parser: Parser) -> None:
    """eds."""
    add_device(parser)
    parser.set_defaults(command=eds)


def eds(options: argparse.Namespace) -> int:
    """The file as it is; with settings the DCF of a device that has them."""
    if given := device_settings(options):
        print(dcf(devices.create(options.device, **given)), end="")
        return OK
    with od_file(devices.find(options.device).eds) as path:
        sys.stdout.buffer.write(path.read_bytes())  # in whatever encoding it is
    return OK


def _devices() -> Iterator[tuple[str, str]]:
    """One that is broken is told, and hides no other."""
    for name in devices.names():
        try:
            yield name, devices.find(name).title
        except UserError as refusal:
            print(refusal, file=sys.stderr)


def _stories(device: str) -> Iterator[tuple[str, str]]:
    """The scenarios that are shipped for a device; each has its name in a line of its own."""
    for file, content in scenarios().items():
        if file.startswith(f"{device}_"):
            found = NAME.search(content.read_text("utf-8"))
            yield file, found[1] if found else ""


def _entries(device: Device) -> Iterator[tuple[str, ...]]:
    for item in device.dictionary().values():
        if item.index < 0x1000:
            continue
        variables = [item] if isinstance(item, ODVariable) else item.subindices.values()
        for variable in variables:
            yield _entry(variable)


def _entry(variable: Any) -> tuple[str, ...]:
    ends = ["" if end is None else str(end) for end in (variable.min, variable.max)]
    default = "" if variable.default is None else variable.default
    return (
        f"0x{variable.index:04X}:{variable.subindex:02X}",
        variable.qualname,
        TYPES.get(variable.data_type, "?"),
        variable.access_type,
        f"0x{default:X}" if isinstance(default, int) and default > 9 else str(default),
        "..".join(ends) if any(ends) else "",
    )


def _table(rows: Iterable[Sequence[str]]) -> None:
    """Columns as wide as they have to be."""
    lines = list(rows)
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = (cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        print("  ".join(cells).rstrip())
