"""Non-volatile memory: what a device keeps over resets and power cycles, in RAM or in a file."""

import json
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from canopen_twins.errors import UserError
from canopen_twins.files.whole import plain_file, write_whole

log = logging.getLogger(__name__)

LARGEST_FILE = 1 << 20  # bytes; a device keeps a few hundred


class Memory:
    """Named sections of JSON values; with a path every change is on the disk when `store` returns.

    A file that cannot be read as such is kept beside as `.bad`, reported, and replaced by an empty
    memory: the device then starts with its defaults.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = None if path is None else plain_file(path)
        self.worn = False
        """Whether it takes nothing any more, as after too many cycles."""
        self._sections: dict[str, dict[str, Any]] = _read(self.path) if self.path else {}

    @property
    def content(self) -> Mapping[str, Mapping[str, Any]]:
        """Everything that is stored, by section."""
        return self._sections

    def load(self, section: str) -> Mapping[str, Any]:
        """What was last stored under this name; empty if nothing was."""
        return dict(self._sections.get(section, {}))

    def store(self, section: str, values: Mapping[str, Any]) -> None:
        """Replace a section.

        Raises:
            OSError: the file cannot be written, or it is worn; the memory is then as before.
        """
        if self.worn:
            raise OSError("it is worn")
        sections = {**self._sections, section: dict(values)}
        if self.path is not None:
            write_whole(self.path, json.dumps(sections, indent=1, sort_keys=True))
        self._sections = sections


def _read(path: Path) -> dict[str, dict[str, Any]]:
    try:
        return _read_or_set_aside(path)
    except OSError as failure:
        raise UserError(f"{path}: {failure.strerror}") from failure


def _read_or_set_aside(path: Path) -> dict[str, dict[str, Any]]:
    if not path.exists():
        return {}
    try:
        return _sections(path)
    except (ValueError, RecursionError) as damage:
        bad = path.with_name(path.name + ".bad")
        path.replace(bad)
        log.error("%s is damaged (%s): kept as %s, the defaults apply", path, damage, bad.name)
        return {}


def _sections(path: Path) -> dict[str, dict[str, Any]]:
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"larger than {LARGEST_FILE} bytes")
    content = json.loads(path.read_text("utf-8"))
    if not isinstance(content, dict) or not all(isinstance(s, dict) for s in content.values()):
        raise ValueError("no object of objects")
    return content
