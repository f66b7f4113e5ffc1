"""list, eds, objects, settings: the devices there are, and what their files say."""

import argparse
import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from typing import Any

from canopen.objectdictionary import ODVariable

from canopen_twins import devices
from canopen_twins.cli.command import DEVICE, OK, Parser, add_device, add_json, device_settings
from canopen_twins.device.dcf import dcf
from canopen_twins.device.device import Device
from canopen_twins.device.settings import TimingSettings, about, declaration
from canopen_twins.errors import UserError
from canopen_twins.files.shipped import od_file, scenarios
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import TYPES

NAME = re.compile(r"^name: (.+)$", re.MULTILINE)


def add_list(parser: Parser) -> None:
    """list."""
    text = "only the scenarios of this one"
    parser.add_argument("device", metavar="DEVICE", nargs="?", help=text)
    add_json(parser)
    parser.set_defaults(command=list_all)


def list_all(options: argparse.Namespace) -> int:
    """The devices, then their scenarios with their names, or those of one device alone."""
    if options.device:
        devices.find(options.device)
    if options.json:
        titles = dict(_devices())
        names = [options.device] if options.device else titles
        _print_json({name: _told(name, titles.get(name, "")) for name in names})
        return OK
    if options.device:
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
    add_json(parser)
    parser.set_defaults(command=objects)


def objects(options: argparse.Namespace) -> int:
    """Every entry of the object dictionary; defaults that depend on the node id are those of 1."""
    variables = list(_variables(devices.create(options.device)))
    if options.json:
        _print_json([_declared(variable) for variable in variables])
        return OK
    heads = ("object", "name", "type", "access", "default", "limits")
    _table([heads, *map(_entry, variables)])
    return OK


def add_settings(parser: Parser) -> None:
    """settings."""
    parser.add_argument("device", metavar="DEVICE", help=DEVICE)
    add_json(parser)
    parser.set_defaults(command=settings)


def settings(options: argparse.Namespace) -> int:
    """Every setting with its default; A-numbers are explained in the device's page of the docs."""
    delivered = devices.find(options.device).settings
    if options.json:
        told = {each.name: declaration(each, type(delivered)) for each in fields(delivered)}
        _print_json(
            {name: {"default": getattr(delivered, name), **said} for name, said in told.items()}
        )
        return OK
    _table(_settings(delivered))
    return OK


def _settings(delivered: TimingSettings) -> Iterator[tuple[str, ...]]:
    yield ("setting", "default", "assumed", "meaning")
    for entry in fields(delivered):
        told = about(entry)
        unit = f" [{told.unit}]" if told.unit else ""
        within = f", {told.range}" if told.range else ""
        live = "; may change while running" if told.live else ""
        value = getattr(delivered, entry.name)
        default = value if isinstance(value, str) else str(value).lower()
        yield (entry.name, default, told.assumed, f"{told.text}{unit}{within}{live}")


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


def _told(name: str, title: str) -> dict[str, object]:
    return {"title": title, "scenarios": dict(_stories(name))}


def _variables(device: Device) -> Iterator[Any]:
    """Every entry that is no data type."""
    for item in device.dictionary().values():
        if item.index < 0x1000:
            continue
        yield from [item] if isinstance(item, ODVariable) else item.subindices.values()


def _declared(variable: Any) -> dict[str, object]:
    default = variable.default
    return {
        "object": address_text((variable.index, variable.subindex)),
        "name": variable.qualname,
        "type": TYPES.get(variable.data_type, "?"),
        "access": variable.access_type,
        "pdo": bool(variable.pdo_mappable),
        "default": default.hex(" ") if isinstance(default, bytes) else default,
        "low": variable.min,
        "high": variable.max,
    }


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


def _print_json(told: object) -> None:
    print(json.dumps(told, indent=2))


def _table(rows: Iterable[Sequence[str]]) -> None:
    """Columns as wide as they have to be."""
    lines = list(rows)
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = (cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        print("  ".join(cells).rstrip())
