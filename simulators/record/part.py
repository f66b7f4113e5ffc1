"""Files and folders that get their name when they are complete; until then it ends in `.part`."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from simulators.errors import UserError

SUFFIX = ".part"


@contextmanager
def file_part(path: Path) -> Iterator[Path]:
    """A name to write to, which is there as `path` at the end.

    Whatever ends the writing early leaves the part with what there is, unless that was wrong
    input; the next one replaces it.

    Raises:
        UserError: it cannot be written there.
    """
    part = _beside(path)
    with _told(path):
        if path.is_dir():
            raise UserError(f"{path} is a directory")
        part.touch()
    try:
        yield part
    except UserError:
        part.unlink()
        raise
    with _told(path):
        part.replace(path)


@contextmanager
def folder_part(path: Path) -> Iterator[Path]:
    """A new folder to fill, which is there as `path` at the end; an empty one may stand there.

    It is left as a part by whatever ends the filling early, unless that was wrong input.

    Raises:
        UserError: something is there already, also as a part, or it cannot be written.
    """
    part = _beside(path)
    with _told(path):
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
    with _told(path):
        if path.exists():
            path.rmdir()
        part.replace(path)


def _beside(path: Path) -> Path:
    path = path.absolute()  # `.` has no name
    return path.with_name(path.name + SUFFIX)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as failure:
        raise UserError(f"{path} cannot be written: {failure.strerror}") from failure
