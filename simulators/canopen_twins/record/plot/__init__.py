"""A picture of a run: set and actual values, states, emergencies, faults, and the verdict.

Drawn by matplotlib, which comes with the extra `plot` and is imported for a picture only.
"""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.files.whole import report_file, write_whole
from canopen_twins.record.plot.page import page
from canopen_twins.record.plot.run import Run
from canopen_twins.scenario import Player

__all__ = ["Plot"]

SUFFIXES = (".html", ".png", ".svg")


class Plot:
    """The picture of one run: `begin` when it begins, `save` when it is over."""

    def __init__(self, path: Path) -> None:
        """Raises `UserError` if there can be no picture, before anything has run."""
        self._suffix = path.suffix.lower()
        if self._suffix not in SUFFIXES:
            raise UserError(f"{path} is no picture: its name ends with {', '.join(SUFFIXES)}")
        self._path = report_file(path)
        self._draw = _drawing()
        self._runs: list[Run] = []

    def begin(self, segment: Segment[Node], player: Player | None) -> None:
        """Look at the nodes of a segment from now on; an observer of `play` and of `reproduce`."""
        self._runs.append(Run(segment, player))

    def save(self) -> None:
        """Write the file.

        Raises:
            UserError: it cannot be written.
        """
        (run,) = self._runs
        if self._suffix == ".html":
            content = page(run, self._draw(run, "svg", headed=False).decode()).encode()
        else:
            content = self._draw(run, self._suffix[1:], headed=True)
        try:
            write_whole(self._path, content)
        except OSError as failure:
            raise UserError(f"{self._path} cannot be written: {failure.strerror}") from failure


def _drawing() -> Callable[..., bytes]:
    try:
        module = import_module("canopen_twins.record.plot.figure")
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] != "matplotlib":
            raise
        raise UserError("a picture needs the extra: pip install 'canopen-twins[plot]'") from missing
    picture: Callable[..., bytes] = module.picture
    return picture
