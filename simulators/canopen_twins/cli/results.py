"""What a run leaves: its verdict for people or for programs, a trace file, a record."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TextIO

from canopen_twins.cli.command import Parser
from canopen_twins.device.device import Device
from canopen_twins.errors import UserError
from canopen_twins.files.whole import report_file, write_whole

if TYPE_CHECKING:
    from canopen_twins.record.trace import Observer
    from canopen_twins.scenario import Scenario, Verdict


def add_reports(parser: Parser) -> None:
    """Verdicts for programs."""
    parser.add_output("--junit", "write the verdict as JUnit XML, for CI")
    parser.add_argument("--json", action="store_true", help="the verdict for programs")


def add_recording(parser: Parser) -> None:
    """What is kept of a run."""
    parser.add_output("--trace", "write the frames to .log, .asc, .blf or .trc")
    parser.add_output("--record", "make a record for `replay` and `diff`", "DIR")


class Announcer:
    """Takes verdicts one by one, and knows at the end what they all are.

    Raises:
        UserError: the report has no place; this is found before anything is played.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._json: bool = options.json
        self._junit: Path | None = options.junit
        self._verdicts: list[Verdict] = []
        if self._junit is not None:
            report_file(self._junit)

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
        # who has told of a verdict has imported it; a run without one does not
        from canopen_twins.scenario.verdict import as_json, as_junit  # noqa: PLC0415

        if self._junit is not None:
            try:
                write_whole(self._junit, as_junit(self._verdicts))
            except OSError as failure:
                raise UserError(f"{self._junit} cannot be written: {failure.strerror}") from failure
        if self._json:
            print(as_json(self._verdicts), flush=True)


@contextmanager
def recording(
    options: argparse.Namespace,
    kind: Literal["play", "run"],
    scenario: Scenario | None,
    participants: Mapping[str, Device],
) -> Iterator[list[Observer]]:
    """Who has to be told of a run; when this is over their files are complete.

    Raises:
        UserError: there is something already, or it cannot be written.
    """
    observers: list[Observer] = []
    if options.trace is None and options.record is None:
        yield observers
        return
    # a run that keeps nothing starts without pydantic
    from canopen_twins.cli.scenario_file import found  # noqa: PLC0415
    from canopen_twins.record.folder import record  # noqa: PLC0415
    from canopen_twins.record.manifest import Manifest, device_files  # noqa: PLC0415
    from canopen_twins.record.trace import trace_file  # noqa: PLC0415

    with ExitStack() as stack:
        if options.trace is not None:
            observers.append(stack.enter_context(trace_file(options.trace, live=kind == "run")))
        if options.record is not None:
            manifest, text = Manifest.of(kind, scenario, participants), None
            if scenario is not None:
                text = stack.enter_context(found(str(scenario.file))).read_bytes()
            files = device_files(participants.values())
            observers.append(stack.enter_context(record(options.record, manifest, text, files)))
        yield observers
