"""A file for one process alone: two twins with one memory would undo what the other has stored."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from simulators.errors import UserError

if sys.platform == "win32":
    import msvcrt

    def _take(file: IO[str]) -> None:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _take(file: IO[str]) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold a file by the lock beside it, as the file itself is replaced at every change.

    The system frees the lock when the process ends, whatever the reason.

    Raises:
        UserError: another process holds it, or the directory cannot be written.
    """
    lock = path.with_name(path.name + ".lock")
    try:
        file = lock.open("w")
    except OSError as failure:
        raise UserError(f"{path} cannot be kept there: {failure.strerror}") from failure
    with file:
        try:
            _take(file)
        except OSError:
            raise UserError(f"{path} belongs to another run") from None
        yield
