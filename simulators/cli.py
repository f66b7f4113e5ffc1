"""The command canopen-twin: what it understands, and how it ends.

Exit codes: 0 all is well, 1 an expectation failed (or a bug, with its traceback), 2 wrong input,
130 interrupted. What a program may read goes to stdout, what people may read to stderr.
"""

import argparse
import logging
import os
import signal
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TypeAlias

from can.cli import add_bus_arguments

from simulators.errors import UserError

FAILED, WRONG_INPUT = 1, 2
PROGRAM = "canopen-twin"

Command = Callable[[argparse.Namespace], int]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit code; a bug comes out as its exception."""
    options = parser().parse_args(arguments)
    level = logging.WARNING - 10 * min(options.verbose, 2)
    logging.basicConfig(format=f"{PROGRAM}: %(message)s", level=level, stream=sys.stderr)
    command: Command = options.command
    try:
        code = command(options)
        sys.stdout.flush()
    except UserError as error:
        for line in str(error).splitlines():
            print(f"{PROGRAM}: {line}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    except BrokenPipeError:  # whoever read our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE
    return code


def parser() -> argparse.ArgumentParser:
    """Everything that can be said on the command line."""
    top = argparse.ArgumentParser(prog=PROGRAM, description="Digital twins of CANopen slaves.")
    top.add_argument("--version", action="version", version=version("canopen-twins"))
    top.add_argument("-v", "--verbose", action="count", default=0, help="tell more; -vv the most")
    commands = top.add_subparsers(metavar="COMMAND", required=True)
    _catalogue(commands)
    _run(commands)
    for name, text in (
        ("play", "play scenarios in simulated time: a trace in candump format, then the verdict"),
        ("check", "say what is wrong with scenarios, without playing them"),
    ):
        command = commands.add_parser(name, help=text, description=text)
        command.add_argument("scenarios", nargs="+", metavar="SCENARIO", help=SCENARIO)
        command.set_defaults(command=_lazy("scenarios", name))
    _vcan(commands)
    return top


SCENARIO = "a file, or the name of one that is shipped"
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # noqa: SLF001


def _catalogue(commands: Commands) -> None:
    shown = {
        "objects": "the object dictionary of a device",
        "settings": "what can be chosen with --set, and what is assumed",
        "faults": "what can be injected",
        "eds": "the EDS file of a device",
    }
    command = commands.add_parser("list", help="the devices and scenarios there are")
    command.set_defaults(command=_lazy("catalogue", "list_all"))
    for name, text in shown.items():
        command = commands.add_parser(name, help=text, description=f"Print {text}.")
        command.add_argument("device", metavar="DEVICE", help="one of `canopen-twin list`")
        command.set_defaults(command=_lazy("catalogue", name))


def _run(commands: Commands) -> None:
    text = "run a twin on a CAN bus in real time, until it is stopped or its scenario is over"
    command = commands.add_parser("run", help=text, description=text)
    command.add_argument("device", metavar="DEVICE", help="one of `canopen-twin list`")
    command.add_argument(
        "-n", "--node-id", type=partial(int, base=0), metavar="ID", help="1..127, or as 0x05"
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="see `settings DEVICE`"
    )
    command.add_argument("--scenario", metavar="SCENARIO", help=SCENARIO)
    command.add_argument(
        "--nvram", type=Path, metavar="FILE", help="keep what the device stores in a file"
    )
    add_bus_arguments(command)
    command.set_defaults(command=_lazy("run", "run"))


def _vcan(commands: Commands) -> None:
    text = "run a command where there is a real vcan0: here, or in a user-mode Linux guest"
    command = commands.add_parser("vcan", help=text, description=text)
    command.add_argument(
        "--limit", type=float, default=300.0, metavar="SECONDS", help="end it after this time (300)"
    )
    command.add_argument(
        "--out", type=Path, metavar="DIR", help="keep what is written there; the rest is lost"
    )
    command.add_argument("words", nargs="+", metavar="COMMAND", help="after --, with its arguments")
    command.set_defaults(command=_lazy("vcan", "vcan"))


def _lazy(module: str, name: str) -> Command:
    """A command whose imports wait until it is wanted, so that --help is there at once."""

    def command(options: argparse.Namespace) -> int:
        function: Command = getattr(import_module(f"simulators.commands.{module}"), name)
        return function(options)

    return command
