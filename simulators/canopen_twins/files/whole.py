"""Files and folders that are there whole, or as they were before; and files that one run holds."""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from canopen_twins.errors import UserError

PART = ".part"


def write_whole(path: Path, text: str) -> None:
    """Replace a file in one step: whoever reads it finds the old content or the new one.

    What is no file, as /dev/stdout, is written to as it is; a link stays one.

    Raises:
        OSError: it cannot be written; it is as before.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        path.write_text(text, "utf-8")
        return
    path = path.resolve()
    handle, name = tempfile.mkstemp(prefix=path.name, suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


@contextmanager
def file_part(path: Path) -> Iterator[Path]:
    """A name to write to, which is there as `path` at the end.

    Whatever ends the writing early leaves the part with what there is, unless that was wrong
    input; the next one replaces it.

    Raises:
        UserError: it cannot be written there.
    """
    part = _beside(path, PART)
    with _writing(path):
        if path.is_dir():
            raise UserError(f"{path} is a directory")
        part.touch()
    try:
        yield part
    except UserError:
        part.unlink()
        raise
    with _writing(path):
        part.replace(path)


@contextmanager
def folder_part(path: Path) -> Iterator[Path]:
    """A new folder to fill, which is there as `path` at the end; an empty one may stand there.

    It is left as a part by whatever ends the filling early, unless that was wrong input.

    Raises:
        UserError: something is there already, also as a part, or it cannot be written.
    """
    part = _beside(path, PART)
    with _writing(path):
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            raise UserError(f"{path} exists: a record has a directory of its own")
        if part.exists():
            raise UserError(f"{part} is left of a run that has not ended: remove it")
        part.mkdir()
    try:
        yield part
    except UserError:
        shutil.rmtree(part)
        raise
    with _writing(path):
        if path.exists():
            path.rmdir()
        part.replace(path)


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold a file by the lock beside it, as the file itself is replaced at every change.

    The system frees the lock when the process ends, whatever the reason.

    Raises:
        UserError: another process holds it, or the directory cannot be written.
    """
    with _writing(path, "kept there"):
        file = _beside(path, ".lock").open("w")
    with file:
        try:
            _lock(file)
        except OSError:
            raise UserError(f"{path} belongs to another run") from None
        yield


def _beside(path: Path, suffix: str) -> Path:
    path = path.absolute()  # `.` has no name
    return path.with_name(path.name + suffix)


@contextmanager
def _writing(path: Path, how: str = "written") -> Iterator[None]:
    try:
        yield
    except OSError as failure:
        raise UserError(f"{path} cannot be {how}: {failure.strerror}") from failure


if sys.platform == "win32":
    import msvcrt

    def _lock(file: IO[str]) -> None:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: IO[str]) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
