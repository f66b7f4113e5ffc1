"""The command canopen-twin: what is chosen is done, and ends with an exit code.

Exit codes: 0 all is well, 1 an expectation failed (or a bug, with its traceback), 2 wrong input,
130 interrupted. What a program may read goes to stdout, what people may read to stderr.
"""

import logging
import os
import sys
from collections.abc import Sequence

from simulators.errors import UserError
from simulators.exit_codes import INTERRUPTED, NO_READER, WRONG_INPUT
from simulators.parser import PROGRAM, Command, parser

__all__ = ["main", "parser"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit code; a bug comes out as its exception."""
    options = parser().parse_args(arguments)
    _log(options.verbose)
    command: Command = options.command
    try:
        code = command(options)
        sys.stdout.flush()
    except UserError as error:
        for line in str(error).splitlines():
            print(f"{PROGRAM}: {line}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # whoever read our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NO_READER
    return code


def _log(verbosity: int) -> None:
    level = logging.WARNING - 10 * min(verbosity, 2)
    logging.basicConfig(format=f"{PROGRAM}: %(message)s", level=level, stream=sys.stderr)
    if not verbosity:  # python-can tells what it raises, too
        logging.getLogger("can").setLevel(logging.CRITICAL)
