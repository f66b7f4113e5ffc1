"""Finds the files of od/ and scenarios/: inside the installed package, beside it in a checkout."""

from contextlib import AbstractContextManager
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path


def od_file(name: str) -> AbstractContextManager[Path]:
    """The path of a file of od/."""
    return as_file(_folder("od") / name)


def scenario_file(name: str) -> AbstractContextManager[Path]:
    """The path of a scenario that is shipped."""
    return as_file(_folder("scenarios") / name)


def scenarios() -> dict[str, Traversable]:
    """The scenarios that are shipped, by file name."""
    entries = sorted(_folder("scenarios").iterdir(), key=lambda entry: entry.name)
    return {entry.name: entry for entry in entries if entry.name.endswith(".yaml")}


def _folder(name: str) -> Traversable:
    package = files("canopen_twins")
    installed = package / name
    return installed if installed.is_dir() else package / ".." / ".." / name
