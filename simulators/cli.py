"""The command canopen-twin: what it understands, and how it ends.

Exit codes: 0 all is well, 1 an expectation failed (or a bug, with its traceback), 2 wrong input,
130 interrupted. What a program may read goes to stdout, what people may read to stderr.
"""

import argparse
import logging
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from errno import EDQUOT, EFBIG, ENOSPC
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeAlias

from simulators.errors import UserError

WRONG_INPUT, INTERRUPTED, NO_READER = 2, 130, 141
PROGRAM = "canopen-twin"

DEVICE = "one of `canopen-twin list`"
OBJECT = "as `objects DEVICE` names it: 0x2014=7, 0x1018:02, 'Run command=1'"
SCENARIO = "a file, or the name of one that is shipped"
HUB = "join a hub (default: 127.0.0.1:29536)"
PLOT = "draw the run: .png, .svg or .html (needs the extra `plot`)"
FIRST = "To begin with: canopen-twin play topcon_overvoltage.yaml"
VERBOSE = "tell more; -vv the most"

Command = Callable[[argparse.Namespace], int]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit code; a bug comes out as its exception."""
    _open_streams()
    options = parser().parse_args(arguments)
    _log(options.verbose)
    command: Command = options.command
    try:
        code = command(options)
        sys.stdout.flush()
    except UserError as error:
        return _refused(str(error))
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # whoever read our output has seen enough
        _end_output()
        return NO_READER
    except OSError as failure:  # a disk that is full is no bug
        if failure.errno not in (ENOSPC, EDQUOT, EFBIG):
            raise
        _end_output()
        return _refused(f"the output cannot be written: {failure.strerror}")
    return code


def _refused(why: str) -> int:
    for line in why.splitlines():
        print(f"{PROGRAM}: {line}", file=sys.stderr)
    return WRONG_INPUT


def _open_streams() -> None:
    """Where the caller has closed stdout or stderr, what is said there is for nobody."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w"))


def _end_output() -> None:
    """Whatever still waits to be written must not fail once more when Python ends."""
    with suppress(OSError):
        sys.stdout.flush()
    with suppress(OSError):  # where it is no file there is nothing to be done
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _log(verbosity: int) -> None:
    level = logging.WARNING - 10 * min(verbosity, 2)
    logging.basicConfig(format=f"{PROGRAM}: %(message)s", level=level, stream=sys.stderr)
    if not verbosity:  # python-can tells what it raises, too
        logging.getLogger("can").setLevel(logging.CRITICAL)


class Parser(argparse.ArgumentParser):
    """The parser of a command; what takes an import is added when the command is chosen."""

    late: Callable[[argparse.ArgumentParser], None] | None = None

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, after everything is there."""
        if self.late is not None:
            self.late(self)
        return super().parse_known_args(args, namespace)


Commands: TypeAlias = "argparse._SubParsersAction[Parser]"  # noqa: SLF001


class Version(argparse.Action):
    """Looks for the version of the installed package only if somebody asks for it."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print it, and end."""
        print(version("canopen-twins"))
        parser.exit()


def parser() -> argparse.ArgumentParser:
    """Everything that can be said on the command line."""
    top = argparse.ArgumentParser(
        prog=PROGRAM, description="Digital twins of CANopen slaves.", epilog=FIRST
    )
    top.add_argument("--version", action=Version, nargs=0, help="print the version")
    top.add_argument("-v", "--verbose", action="count", default=0, help=VERBOSE)
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    _catalogue(commands)
    _run(commands)
    _hub(commands)
    _play(commands)
    text = "say what is wrong with scenarios, without playing them"
    command = _command(commands, "check", text, "scenarios", "check")
    command.add_argument("scenarios", nargs="+", metavar="SCENARIO", help=SCENARIO)
    text = "print the JSON Schema of scenarios or of bench files, for editors"
    command = _command(commands, "schema", text, "schema", "schema")
    command.add_argument("file", nargs="?", choices=("scenario", "bench"), default="scenario")
    _records(commands)
    _vcan(commands)
    return top


def _command(commands: Commands, name: str, text: str, module: str, function: str) -> Parser:
    """A command whose imports wait until it is chosen, so that --help is there at once."""

    def command(options: argparse.Namespace) -> int:
        run: Command = getattr(import_module(f"simulators.commands.{module}"), function)
        return run(options)

    parser = commands.add_parser(name, help=text, description=text)
    parser.add_argument("-v", "--verbose", action="count", default=argparse.SUPPRESS, help=VERBOSE)
    parser.set_defaults(command=command)
    return parser


def _catalogue(commands: Commands) -> None:
    text = "print the devices there are, and the scenarios for each of them"
    command = _command(commands, "list", text, "catalogue", "list_all")
    text = "only the scenarios of this one"
    command.add_argument("device", metavar="DEVICE", nargs="?", help=text)
    text = "print the EDS file of a device, or its DCF with the settings that are given"
    command = _command(commands, "eds", text, "catalogue", "eds")
    _device_arguments(command)
    for name, text in (
        ("objects", "print the object dictionary of a device"),
        ("settings", "print what can be chosen with --set, and what is assumed"),
    ):
        command = _command(commands, name, text, "catalogue", name)
        command.add_argument("device", metavar="DEVICE", help=DEVICE)
    text = "say what the manual says of an object, and whether it takes a value and why not"
    command = _command(commands, "why", text, "why", "explain")
    _device_arguments(command)
    command.add_argument("object", metavar="OBJECT[=VALUE]", help=OBJECT)
    command = _command(commands, "faults", "print what can be injected", "faults", "faults")
    command.add_argument(
        "device", metavar="DEVICE", nargs="?", help=f"{DEVICE}; none: what every device has"
    )
    command.add_argument("--json", action="store_true", help="for programs")


def _kept(command: Parser) -> None:
    command.add_argument(
        "--trace", type=Path, metavar="FILE", help="write the frames to .log, .asc, .blf or .trc"
    )
    command.add_argument(
        "--record", type=Path, metavar="DIR", help="make a record for `replay` and `diff`"
    )


def _records(commands: Commands) -> None:
    text = "live through a record again: its frames in candump format, 1 if they are others now"
    command = _command(commands, "replay", text, "replay", "replay")
    command.add_argument("record", type=Path, metavar="DIR", help="of --record")
    command.add_argument("--plot", type=Path, metavar="FILE", help=PLOT)
    text = "explain the first difference of two records or trace files, 1 if there is one"
    command = _command(commands, "diff", text, "diff", "diff")
    for name in ("a", "b"):
        command.add_argument(name, type=Path, metavar=name.upper(), help="a record, or a trace")


def _play(commands: Commands) -> None:
    text = "play scenarios in simulated time: a trace in candump format, then the verdict"
    command = _command(commands, "play", text, "play", "play")
    command.add_argument("scenarios", nargs="+", metavar="SCENARIO", help=SCENARIO)
    _reports(command)
    command.add_argument("--plot", type=Path, metavar="FILE", help=PLOT)
    _kept(command)


def _run(commands: Commands) -> None:
    text = "run twins on a CAN bus in real time, until they are stopped or a scenario is over"
    command = _command(commands, "run", text, "run", "run")
    text = f"{DEVICE}, or a bench file; with --scenario it may be left out"
    _device_arguments(command, text, nargs="?")
    command.add_argument("--scenario", metavar="SCENARIO", help=SCENARIO)
    command.add_argument(
        "--nvram", type=Path, metavar="FILE", help="keep what the device stores in a file"
    )
    command.add_argument(
        "--hub", nargs="?", const="", metavar="HOST:PORT", help=f"{HUB}; the bus is that of -c"
    )
    command.add_argument(
        "--real-bus", action="store_true", help="the bus may have real devices on it"
    )
    _reports(command)
    _kept(command)
    command.late = _bus_arguments


def _reports(command: Parser) -> None:
    command.add_argument(
        "--junit", type=Path, metavar="FILE", help="write the verdict as JUnit XML, for CI"
    )
    command.add_argument("--json", action="store_true", help="the verdict for programs")


def _hub(commands: Commands) -> None:
    text = "run a hub: buses that every process of this machine can join, with no vcan and no root"
    command = _command(commands, "hub", text, "hub", "hub")
    command.add_argument(
        "--listen", default="", metavar="HOST:PORT", help="where (default: 127.0.0.1:29536)"
    )


def _device_arguments(command: Parser, text: str = DEVICE, nargs: str | None = None) -> None:
    command.add_argument("device", metavar="DEVICE", nargs=nargs, help=text)
    command.add_argument(
        "-n", "--node-id", type=partial(int, base=0), metavar="ID", help="1..127, or as 0x05"
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="see `settings DEVICE`"
    )
    command.add_argument("--config", metavar="FILE", help="short for --set config=FILE")


def _bus_arguments(command: argparse.ArgumentParser) -> None:
    from can.cli import add_bus_arguments  # noqa: PLC0415

    add_bus_arguments(command)


def _vcan(commands: Commands) -> None:
    text = "run a command where there is a real vcan0: here, or in a user-mode Linux guest"
    command = _command(commands, "vcan", text, "vcan", "vcan")
    command.add_argument(
        "--limit", type=float, default=300.0, metavar="SECONDS", help="end it after this time (300)"
    )
    command.add_argument(
        "--out", type=Path, metavar="DIR", help="keep what is written there; the rest is lost"
    )
    command.add_argument("words", nargs="+", metavar="COMMAND", help="after --, with its arguments")
