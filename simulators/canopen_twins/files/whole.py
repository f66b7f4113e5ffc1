"""Files and folders that are there whole, or as they were before; and files that one run holds."""

import os
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from canopen_twins.errors import UserError

PART = ".part"


def plain_file(path: Path) -> Path:
    """Where a file that a user names is, or may be made: links have been followed.

    It is looked at before anything is opened or moved: a device would be replaced by a file, a pipe
    would wait for ever, and two names of one file would be two memories.

    Raises:
        UserError: it is no plain file, or there is no directory for one.
    """
    real, mode = _looked_at(path)
    if mode is not None and not stat.S_ISREG(mode):
        raise UserError(f"{path} is a device, a pipe or the like, where a plain file is wanted")
    return real


def report_file(path: Path) -> Path:
    """The same for what is written at the end, which may go to a device or a pipe: /dev/stdout."""
    return _looked_at(path)[0]


def real_path(path: Path) -> Path:
    """Where a name leads; raises `UserError` if its links lead in a circle."""
    try:
        real = path.resolve()
        if not real.is_symlink():  # Python 3.13 leaves one that leads to itself
            return real
    except RuntimeError:
        pass
    except OSError as failure:  # a name that is too long; the directory we are in is gone
        raise UserError(f"{path}: {failure.strerror}") from failure
    raise UserError(f"{path}: links lead in a circle")


def _looked_at(path: Path) -> tuple[Path, int | None]:
    """Where something that is no directory is, or may be, and its mode if it is there."""
    real = real_path(path)
    try:
        mode = real.stat().st_mode
    except FileNotFoundError:
        if not real.parent.is_dir():
            raise UserError(f"{path}: there is no directory for it") from None
        return real, None
    except OSError as failure:  # a name that is too long, a file where a directory is wanted
        raise UserError(f"{path}: {failure.strerror}") from failure
    if stat.S_ISDIR(mode):
        raise UserError(f"{path} is a directory, where a plain file is wanted")
    return real, mode


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


def write_whole(path: Path, content: str | bytes) -> None:
    """Replace a file in one step: whoever reads it finds the old content or the new one.

    What is no file, as /dev/stdout, is written to as it is; a link stays one, and a mode, too.

    Raises:
        OSError: it cannot be written; it is as before.
    """
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    if path.exists() and not path.is_file() and not path.is_dir():
        path.write_bytes(data)
        return
    path = path.resolve()
    part = path.with_name(f".{os.urandom(8).hex()}{PART}")  # the name itself may be of full length
    handle = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)  # less the umask
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
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
    """A file that is written in its place, for others to read along.

    An older one is a part meanwhile; it is back where wrong input ends the writing, else gone.

    Raises:
        UserError: it cannot be written there, or another run is writing it.
    """
    path = plain_file(path)
    older = _beside(path, PART) if path.exists() else None
    with ExitStack() as stack:
        with _writing(path):
            if older is not None:
                with path.open("rb") as there:
                    _lock_for(path, there.fileno())
                path.replace(older)
            _lock_for(path, stack.enter_context(path.open("wb")).fileno())
        try:
            yield path
        except UserError:
            path.unlink()
            if older is not None:
                older.replace(path)
            raise
    if older is not None:
        older.unlink()


@contextmanager
def file_part(path: Path) -> Iterator[Path]:
    """A name to write to, which is there as `path` at the end.

    Whatever ends the writing early leaves the part with what there is, unless that was wrong
    input; the next one replaces it.

    Raises:
        UserError: it cannot be written there, or another run is writing it.
    """
    path = plain_file(path)
    part = _beside(path, PART)
    with ExitStack() as stack:
        with _writing(path):
            file = stack.enter_context(plain_file(part).open("a"))
            _lock_for(path, file.fileno())
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
    with ExitStack() as stack:
        with _writing(path):
            told, path = path, real_path(path)  # `.` has no name, and a link stays one
            if path.exists() and (not path.is_dir() or any(path.iterdir())):
                raise UserError(f"{told} exists: a record has a directory of its own")
            part = _beside(path, PART)
            if part.exists():
                with _folder(part) as handle:
                    _lock_for(told, handle)
                raise UserError(f"{part} is left of a run that has not ended: remove it")
            part.mkdir()
            _lock_for(told, stack.enter_context(_folder(part)))
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
    with _writing(path, "kept there"):  # a link that stands there loses nothing
        file = plain_file(_beside(path, ".lock")).open("a")
    with file:
        _lock_for(path, file.fileno())
        yield


def _beside(path: Path, suffix: str) -> Path:
    return path.with_name(path.name + suffix)


@contextmanager
def _writing(path: Path, how: str = "written") -> Iterator[None]:
    try:
        yield
    except OSError as failure:
        raise UserError(f"{path} cannot be {how}: {failure.strerror}") from failure


def _lock_for(path: Path, handle: int) -> None:
    try:
        _lock(handle)
    except OSError:
        raise UserError(f"{path} belongs to another run") from None


if sys.platform == "win32":
    import msvcrt

    def _lock(handle: int) -> None:
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(handle: int) -> None:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def _folder(path: Path) -> Iterator[int]:
    """What a lock of a folder holds."""
    handle = os.open(path, os.O_RDONLY)
    try:
        yield handle
    finally:
        os.close(handle)
