"""A command and its parser; what it does is imported when it is chosen, so that --help is there."""

import argparse
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeAlias

VERBOSE = "tell more; -vv the most"

Command = Callable[[argparse.Namespace], int]
"""Takes the parsed options and returns the exit code."""


class Parser(argparse.ArgumentParser):
    """The parser of a command; what takes an import is added when the command is chosen."""

    late: Callable[[argparse.ArgumentParser], None] | None = None

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, after everything is there."""
        if self.late is not None:
            self.late(self)
        return super().parse_known_args(args, namespace)


Commands: TypeAlias = "argparse._SubParsersAction[Parser]"  # noqa: SLF001


def verbosity(parser: argparse.ArgumentParser, default: Any = argparse.SUPPRESS) -> None:
    """-v, which may stand before the name of a command or behind it."""
    parser.add_argument("-v", "--verbose", action="count", default=default, help=VERBOSE)


def add(
    commands: Commands, name: str, text: str, module: str, function: str | None = None
) -> Parser:
    """A command that is a function of a module of `cli.commands`, named like it or not."""

    def command(options: argparse.Namespace) -> int:
        run: Command = getattr(
            import_module(f"canopen_twins.cli.commands.{module}"), function or name
        )
        return run(options)

    parser = commands.add_parser(name, help=text, description=text)
    verbosity(parser)
    parser.set_defaults(command=command)
    return parser
