"""faults: what can go wrong with a device, with every device, or with a twin that runs."""

import argparse
import json
from collections.abc import Mapping
from itertools import groupby
from typing import Any

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.command import DEVICE, OK, Parser, add_json
from canopen_twins.cli.touch import add_port, chosen
from canopen_twins.device.device import Device
from canopen_twins.errors import UserError
from canopen_twins.faults import AIM, connect
from canopen_twins.live.running import all_running

OF_THE_PROTOCOL = ("code", "cob_id", "identifier", "value")
LONGEST_WORD = 0xFFFF
HEADINGS = {"device": "Of this device:"}

Declared = Mapping[str, Any]
"""What is told of a fault or of a parameter."""


def add_faults(parser: Parser) -> None:
    """faults."""
    text = f"{DEVICE}; none: a twin that runs with --control, without one what every device has"
    parser.add_argument("device", metavar="DEVICE", nargs="?", help=text)
    add_json(parser)
    add_port(parser)
    parser.set_defaults(command=faults)


def faults(options: argparse.Namespace) -> int:
    """Every fault with what a master should see of it and its parameters, as text or as JSON."""
    known = _known(options)
    if options.json:
        print(json.dumps(known, indent=2))
        return OK
    if active := [told["active"] for told in known.values() if told.get("active")]:
        print("Active:", end="\n\n")
        print(*active, sep="\n", end="\n\n")
    for level, group in groupby(known.items(), key=lambda item: item[1]["level"]):
        print(HEADINGS.get(level, f"Of every device, {level} level:"), end="\n\n")
        for name, fault in group:
            _tell(name, fault)
        print()
    print("Which one is struck, wherever it says so above:", end="\n\n")
    _tell_parameters({name: told.declaration for name, told in AIM.items()})
    return OK


def _known(options: argparse.Namespace) -> Mapping[str, Declared]:
    """By name; of a twin that runs also whether a fault is active, in words."""
    of_running = options.at or options.node
    if options.device and of_running:
        raise UserError(f"a twin that runs is meant, or {options.device}: leave one of them out")
    if options.device or not (of_running or all_running()):
        device = devices.create(options.device) if options.device else Device()
        around = connect(Segment(), device, "").faults.known
        return {name: fault.declaration for name, fault in around.items()}
    told = chosen(options).faults
    active = {each["name"]: each["words"] for each in told["active"]}
    return {name: {**each, "active": active.get(name)} for name, each in told["known"].items()}


def _tell(name: str, fault: Declared) -> None:
    print(f"{name}\n    {fault['text']}")
    if fault["sees"]:
        print(f"    The master sees: {fault['sees']}")
    parameters = fault["parameters"]
    own = {key: told for key, told in parameters.items() if not _aims(key, told)}
    _tell_parameters(own)
    if len(own) < len(parameters):
        print(f"    {', '.join(AIM)}: which one is struck")


def _aims(parameter: str, told: Declared) -> bool:
    return parameter in AIM and AIM[parameter].declaration == told


def _tell_parameters(parameters: Mapping[str, Declared]) -> None:
    for parameter, told in parameters.items():
        word = _word(parameter, told["default"])
        default = "" if told["default"] in (None, "") else f" (default: {word})"
        print(f"    {parameter}: {told['text']}{default}")


def _word(parameter: str, default: object) -> str:
    """A default, those of the protocol as it writes them."""
    if parameter not in OF_THE_PROTOCOL or not isinstance(default, int):
        return str(default)
    return f"0x{default:08X}" if default > LONGEST_WORD else f"0x{default:X}"
