"""The commands that tell about devices; none of them runs one on a bus."""

from canopen_twins.cli.parser.arguments import DEVICE, device
from canopen_twins.cli.parser.command import Commands, add

OBJECT = "as `objects DEVICE` names it: 0x2014=7, 0x1018:02, 'Run command=1'"


def add_devices(commands: Commands) -> None:
    """list, eds, objects, settings, why and faults."""
    text = "print the devices there are, and the scenarios for each of them"
    parser = add(commands, "list", text, "catalogue", "list_all")
    text = "only the scenarios of this one"
    parser.add_argument("device", metavar="DEVICE", nargs="?", help=text)
    text = "print the EDS file of a device, or its DCF with the settings that are given"
    device(add(commands, "eds", text, "catalogue"))
    text = "print the object dictionary of a device"
    add(commands, "objects", text, "catalogue").add_argument(
        "device", metavar="DEVICE", help=DEVICE
    )
    text = "print what can be chosen with --set, and what is assumed"
    add(commands, "settings", text, "catalogue").add_argument(
        "device", metavar="DEVICE", help=DEVICE
    )
    _why(commands)
    _faults(commands)


def _why(commands: Commands) -> None:
    text = "say what the manual says of an object, and whether it takes a value and why not"
    parser = add(commands, "why", text, "why", "explain")
    device(parser)
    parser.add_argument("object", metavar="OBJECT[=VALUE]", help=OBJECT)


def _faults(commands: Commands) -> None:
    parser = add(commands, "faults", "print what can be injected", "faults")
    parser.add_argument(
        "device", metavar="DEVICE", nargs="?", help=f"{DEVICE}; none: what every device has"
    )
    parser.add_argument("--json", action="store_true", help="for programs")
