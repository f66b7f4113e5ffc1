"""What can be said on the command line."""

import argparse
from importlib.metadata import version

from canopen_twins.cli.parser.buses import add_hub, add_run, add_vcan
from canopen_twins.cli.parser.command import Command, Parser, verbosity
from canopen_twins.cli.parser.devices import add_devices
from canopen_twins.cli.parser.scenarios import add_records, add_scenarios

__all__ = ["PROGRAM", "Command", "parser"]

PROGRAM = "canopen-twin"
FIRST = "To begin with: canopen-twin play topcon_overvoltage.yaml"


class Version(argparse.Action):
    """Looks for the version of the installed package only if somebody asks for it."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print it, and end."""
        print(version("canopen-twins"))
        parser.exit()


def parser() -> argparse.ArgumentParser:
    """Everything that can be said; `command` is what was chosen."""
    text = "Digital twins of CANopen slaves."
    top = argparse.ArgumentParser(prog=PROGRAM, description=text, epilog=FIRST)
    top.add_argument("--version", action=Version, nargs=0, help="print the version")
    verbosity(top, default=0)
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for add in (add_devices, add_run, add_hub, add_scenarios, add_records, add_vcan):
        add(commands)
    return top
