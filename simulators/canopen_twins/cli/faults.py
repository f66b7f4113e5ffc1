"""faults: what can go wrong with a device, and with every device, level by level."""

import argparse
import json
from collections.abc import Mapping
from itertools import groupby

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.command import DEVICE, OK, Parser, add_json
from canopen_twins.device.device import Device
from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.faults import AIM, connect

OF_THE_PROTOCOL = ("code", "cob_id", "identifier", "value")
LONGEST_WORD = 0xFFFF
HEADINGS = {"device": "Of this device:"}


def add_faults(parser: Parser) -> None:
    """faults."""
    text = f"{DEVICE}; none: what every device has"
    parser.add_argument("device", metavar="DEVICE", nargs="?", help=text)
    add_json(parser)
    parser.set_defaults(command=faults)


def faults(options: argparse.Namespace) -> int:
    """Every fault with what a master should see of it and its parameters, as text or as JSON."""
    device = devices.create(options.device) if options.device else Device()
    known = connect(Segment(), device, "").faults.known
    if options.json:
        print(json.dumps({name: fault.declaration for name, fault in known.items()}, indent=2))
        return OK
    for level, group in groupby(known.items(), key=lambda item: item[1].level):
        print(HEADINGS.get(level, f"Of every device, {level} level:"), end="\n\n")
        for name, fault in group:
            _tell(name, fault)
        print()
    print("Which one is struck, wherever it says so above:", end="\n\n")
    _tell_parameters(AIM)
    return OK


def _tell(name: str, fault: Fault) -> None:
    print(f"{name}\n    {fault.text}")
    if fault.sees:
        print(f"    The master sees: {fault.sees}")
    own = {key: told for key, told in fault.parameters.items() if AIM.get(key) is not told}
    _tell_parameters(own)
    if len(own) < len(fault.parameters):
        print(f"    {', '.join(AIM)}: which one is struck")


def _tell_parameters(parameters: Mapping[str, Parameter]) -> None:
    for parameter, told in parameters.items():
        default = "" if told.default in (None, "") else f" (default: {_word(parameter, told)})"
        print(f"    {parameter}: {told.text}{default}")


def _word(parameter: str, told: Parameter) -> str:
    """A default, those of the protocol as it writes them."""
    if parameter not in OF_THE_PROTOCOL or not isinstance(told.default, int):
        return str(told.default)
    return f"0x{told.default:08X}" if told.default > LONGEST_WORD else f"0x{told.default:X}"
