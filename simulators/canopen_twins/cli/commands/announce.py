"""Tells verdicts: to people on stdout, or to programs with `--json` and `--junit FILE`."""

import argparse
import sys
from pathlib import Path
from typing import TextIO

from canopen_twins.errors import UserError
from canopen_twins.files.whole import write_whole
from canopen_twins.scenario import Verdict
from canopen_twins.scenario.verdict import as_json, as_junit


class Announcer:
    """Takes verdicts one by one, and knows at the end what they all are.

    Raises:
        UserError: the report has no place; this is found before anything is played.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._json: bool = options.json
        self._junit: Path | None = options.junit
        self._verdicts: list[Verdict] = []
        if self._junit is not None and not self._junit.parent.is_dir():
            raise UserError(f"{self._junit}: there is no directory {self._junit.parent}")
        if self._junit is not None and self._junit.is_dir():
            raise UserError(f"{self._junit} is a directory")

    @property
    def wanted(self) -> bool:
        """Whether a program waits for it, which has to hear of a run that was stopped, too."""
        return self._json or self._junit is not None

    @property
    def trace(self) -> TextIO | None:
        """Where frames are written."""
        return None if self._json else sys.stdout

    def tell(self, verdict: Verdict) -> None:
        """Take one; people hear of it at once."""
        self._verdicts.append(verdict)
        if not self._json:
            print(verdict)

    def end(self) -> None:
        """Tell programs of all.

        Raises:
            UserError: the report cannot be written.
        """
        if self._junit is not None:
            try:
                write_whole(self._junit, as_junit(self._verdicts))
            except OSError as failure:
                raise UserError(f"{self._junit} cannot be written: {failure.strerror}") from failure
        if self._json:
            print(as_json(self._verdicts), flush=True)
