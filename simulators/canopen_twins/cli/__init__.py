"""The command canopen-twin: what is chosen is done, and ends with an exit code.

Exit codes: 0 all is well, 1 an expectation failed (or a bug, with its traceback), 2 wrong input,
130 interrupted. What a program may read goes to stdout, what people may read to stderr.
"""

import logging
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from errno import EDQUOT, EFBIG, ENOSPC

from canopen_twins.cli.exit_codes import INTERRUPTED, NO_READER, WRONG_INPUT
from canopen_twins.cli.parser import PROGRAM, Command, parser
from canopen_twins.errors import UserError

__all__ = ["main", "parser"]


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
