"""The command canopen-twin: what is chosen is done, and ends with an exit code.

What a program may read goes to stdout, what people may read to stderr. The module of a command is
imported when the command is chosen, so that --help is there at once.
"""

import argparse
import logging
import os
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from errno import EDQUOT, EFBIG, ENOSPC
from functools import partial
from importlib import import_module
from io import TextIOWrapper
from textwrap import fill

from canopen_twins.cli.command import (
    INTERRUPTED,
    NO_READER,
    WRONG_INPUT,
    OneLineParser,
    Parser,
    add_verbosity,
)
from canopen_twins.cli.examples import EXAMPLES
from canopen_twins.errors import UserError

__all__ = ["main", "parser"]

PROGRAM = "canopen-twin"
FIRST = "To begin with: canopen-twin play topcon_overvoltage.yaml"
COMMANDS: Mapping[str, Mapping[str, str]] = {
    "devices": {
        "list": "print the devices there are, and the scenarios for each of them",
        "eds": "print the EDS file of a device, or its DCF with the settings that are given",
        "objects": "print the object dictionary of a device",
        "settings": "print what can be chosen with --set, and what is assumed",
    },
    "why": {
        "why": "say what the manual says of an object, and whether it takes a value and why not"
    },
    "faults": {"faults": "print what can be injected, into a device or a twin that runs"},
    "touch": {
        "inject": "let something go wrong with a twin that runs",
        "clear": "take a fault of a twin that runs away, or all of them",
        "set": "change live settings of a twin that runs, such as the load",
        "get": "print values of a twin that runs, read without a frame on the bus",
        "power": "switch the supply of a twin that runs on or off",
        "state": "print how the twins are that run",
        "watch": "print what happens on the bus of a twin that runs, as it happens",
    },
    "run": {
        "run": "run twins on a CAN bus in real time, until they are stopped or a scenario is over"
    },
    "hub": {
        "hub": "run a hub: buses that every process of this machine can join, with no vcan "
        "and no root"
    },
    "play": {
        "play": "play scenarios in simulated time: a trace in candump format, then the verdict"
    },
    "conform": {
        "conform": "play the topics of a conformance test against a slave: a twin in simulated "
        "time, or whatever is on a bus"
    },
    "hunt": {
        "hunt": "search for faults that a master does not survive: each find is a scenario file"
    },
    "campaign": {
        "campaign": "play a contract with every combination of a grid, each once, and tell of all"
    },
    "check": {
        "check": "say what is wrong with scenarios, bench files and EDS files",
        "schema": "print the JSON Schema of scenarios, bench files or device files, for editors",
    },
    "new_device": {"new-device": "write a package to start from, for a device of your own"},
    "replay": {
        "replay": "live through a record again: its frames in candump format, "
        "1 if they are others now",
        "diff": "explain the first difference of two records or trace files, 1 if there is one",
    },
    "compare": {
        "compare": "hold a trace of real devices against their twins, 1 if they differ",
    },
    "decode": {"decode": "print a trace in words, with the names of dictionaries"},
    "shell": {
        "completion": "print what completes commands, options and devices in a shell",
        "man": "print the page of the manual",
    },
    "vcan": {
        "vcan": "run a command where there is a real vcan0: here, or in a user-mode Linux guest"
    },
}
"""By module; its `add_NAME` fills the parser, and sets `command`: from options to an exit code."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit code; a bug comes out as its exception."""
    _open_streams()
    try:
        options = parser().parse_args(arguments)
        _log(-1 if options.quiet else options.verbose)
        code: int = options.command(options)
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


def parser() -> argparse.ArgumentParser:
    """Everything that can be said; `command` is what was chosen."""
    text = "Digital twins of CANopen slaves."
    top = OneLineParser(prog=PROGRAM, description=text, epilog=FIRST)
    top.add_argument("--version", action=Version, nargs=0, help="print the version")
    add_verbosity(top, default=0)
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for module, told in COMMANDS.items():
        for name, text in told.items():
            command = commands.add_parser(name, help=text, description=text)
            command.complete = partial(_complete, name, module)
    return top


class Version(argparse.Action):
    """Looks for the version of the installed package only if somebody asks for it."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print it, and end."""
        from importlib.metadata import version  # noqa: PLC0415 - a third of the time of --help

        print(version("canopen-twins"))
        parser.exit()


def _complete(name: str, module: str, parser: Parser) -> None:
    add_verbosity(parser)
    add = f"add_{name.replace('-', '_')}"
    getattr(import_module(f"canopen_twins.cli.{module}"), add)(parser)
    examples = "".join(f"\n  {PROGRAM} {example}" for example in EXAMPLES[name])
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    told = [fill(parser.epilog)] if parser.epilog else []
    parser.description = fill(parser.description or "")
    parser.epilog = "\n\n".join([*told, f"examples:{examples}"])


def _refused(why: str) -> int:
    for line in why.splitlines():
        print(f"{PROGRAM}: {line}", file=sys.stderr)
    return WRONG_INPUT


def _open_streams() -> None:
    """What is said is written; where the caller has closed stdout or stderr, it is for nobody."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w"))
        stream = getattr(sys, name)
        if isinstance(stream, TextIOWrapper):  # whatever it is encoded in, a verdict is written
            stream.reconfigure(errors="backslashreplace")


def _end_output() -> None:
    """Whatever still waits to be written must not fail once more when Python ends."""
    with suppress(OSError):
        sys.stdout.flush()
    with suppress(OSError):  # where it is no file there is nothing to be done
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _log(verbosity: int) -> None:
    level = logging.WARNING - 10 * min(verbosity, 2)  # -1: errors alone
    logging.basicConfig(format=f"{PROGRAM}: %(message)s", level=level, stream=sys.stderr)
    if verbosity <= 0:  # python-can tells what it raises, too
        logging.getLogger("can").setLevel(logging.CRITICAL)
