"""Which control ports of this user there are: a file for each in the runtime directory."""

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from canopen_twins.errors import UserError
from canopen_twins.files.whole import held, write_whole

NAME = "canopen-twins"
LARGEST = 1 << 16  # bytes


class Running(NamedTuple):
    """A run with a control port."""

    title: str
    """What is run, as in the ready line."""
    address: str
    """http://HOST:PORT"""
    token: str = ""


@contextmanager
def announced(running: Running) -> Iterator[None]:
    """Can be found by this user until the end; a run that is killed is found no more, either.

    Raises:
        UserError: the runtime directory cannot be written, or may be written by others.
    """
    path = _folder() / f"{running.address.rpartition(':')[2]}-{os.getpid()}.json"
    with held(path):  # whoever can hold it finds what a dead run has left
        try:
            write_whole(path, json.dumps(running._asdict()))
        except OSError as failure:
            raise UserError(f"{path} cannot be written: {failure.strerror}") from failure
        try:
            yield
        finally:
            _remove(path)


def all_running() -> list[Running]:
    """Those that run now, by their titles; what dead ones have left is removed.

    Raises:
        UserError: as `announced`.
    """
    found = (_living(path) for path in sorted(_folder().glob("*.json")))
    return sorted(running for running in found if running is not None)


def _living(path: Path) -> Running | None:
    try:
        with held(path):
            _remove(path)
        return None
    except UserError:  # somebody holds it
        pass
    with suppress(OSError, ValueError, TypeError), path.open(encoding="utf-8") as file:
        return Running(**{key: str(value) for key, value in json.loads(file.read(LARGEST)).items()})
    return None


def _remove(path: Path) -> None:
    path.unlink(missing_ok=True)
    path.with_name(f"{path.name}.lock").unlink(missing_ok=True)


def _folder() -> Path:
    """In $XDG_RUNTIME_DIR, or where there is none in a directory of our own among temporary files.

    Raises:
        UserError: it cannot be made, or it belongs to somebody else.
    """
    given = os.environ.get("XDG_RUNTIME_DIR", "")
    user = os.getuid() if hasattr(os, "getuid") else "user"
    above = Path(given) if given and os.access(given, os.W_OK) else None
    folder = above / NAME if above else Path(tempfile.gettempdir()) / f"{NAME}-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        told = folder.lstat()
    except OSError as failure:
        raise UserError(f"{folder} cannot be made: {failure.strerror}") from failure
    if hasattr(os, "getuid") and (told.st_uid != os.getuid() or told.st_mode & 0o77):
        raise UserError(f"{folder} is not for you alone: others could send you to their twins")
    return folder
