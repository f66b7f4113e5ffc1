"""Files and folders that are there whole, or as they were before; and files that one run holds."""

import os
import secrets
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from canopen_twins.errors import UserError

PART = ".part"


def plain_file(path: Path) -> Path:
    """Where a file that a user names is, or may be made: links have been followed.

    It is looked at before anything is opened or moved: a device would be replaced by a file, a pipe
    would wait for ever, and two names of one file would be two memories.

    Raises:
        UserError: it is no plain file, or there is no directory for one.
    """
    try:
        real = path.resolve()
        mode = real.stat().st_mode if real.exists() else None
    except (OSError, RuntimeError) as failure:  # a link that leads to itself, a name too long
        words = failure.strerror if isinstance(failure, OSError) else "links lead in a circle"
        raise UserError(f"{path}: {words}") from failure
    if real.is_symlink():  # as Python 3.13 leaves it
        raise UserError(f"{path}: links lead in a circle")
    if mode is None and not real.parent.is_dir():
        raise UserError(f"{path}: there is no directory for it")
    if mode is not None and not stat.S_ISREG(mode):
        kind = "a directory" if stat.S_ISDIR(mode) else "a device, a pipe or the like"
        raise UserError(f"{path} is {kind}, where a plain file is wanted")
    return real


def read_plain(path: Path, largest: int) -> bytes:
    """The content of a file that a user names.

    Raises:
        UserError: it is no plain file, it is larger than `largest` bytes, or it cannot be read.
    """
    real = plain_file(path)
    try:
        with real.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as failure:
        raise UserError(f"{path}: {failure.strerror}") from failure
    if len(content) > largest:
        raise UserError(f"{path} is larger than {largest // 1024} KiB")
    return content


def write_whole(path: Path, text: str) -> None:
    """Replace a file in one step: whoever reads it finds the old content or the new one.

    What is no file, as /dev/stdout, is written to as it is; a link stays one, and a mode, too.

    Raises:
        OSError: it cannot be written; it is as before.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        path.write_text(text, "utf-8")
        return
    path = path.resolve()
    part = path.with_name(f".{secrets.token_hex(8)}{PART}")  # the name itself may be of full length
    handle = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)  # less the umask
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            part.chmod(stat.S_IMODE(path.stat().st_mode))
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


@contextmanager
def live_file(path: Path) -> Iterator[Path]:
    """A file that is written in its place, for others to read along; an older one is gone at once.

    Raises:
        UserError: it cannot be written there.
    """
    path = plain_file(path)
    with _writing(path):
        path.write_bytes(b"")
    yield path


@contextmanager
def file_part(path: Path) -> Iterator[Path]:
    """A name to write to, which is there as `path` at the end.

    Whatever ends the writing early leaves the part with what there is, unless that was wrong
    input; the next one replaces it.

    Raises:
        UserError: it cannot be written there.
    """
    path = plain_file(path)
    part = _beside(path, PART)
    with _writing(path):
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
    with _writing(path):
        told, path = path, path.resolve()  # `.` has no name, and a link stays one
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            raise UserError(f"{told} exists: a record has a directory of its own")
        part = _beside(path, PART)
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
    path = plain_file(path)
    with _writing(path, "kept there"):
        file = plain_file(_beside(path, ".lock")).open(
            "a"
        )  # a link that stands there loses nothing
    with file:
        try:
            _lock(file)
        except OSError:
            raise UserError(f"{path} belongs to another run") from None
        yield


def _beside(path: Path, suffix: str) -> Path:
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
