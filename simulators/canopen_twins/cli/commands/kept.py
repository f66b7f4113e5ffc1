"""What is kept of a run: a trace file and a record, as the command line wants them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from canopen_twins import scenario as replay
from canopen_twins.device.device import Device
from canopen_twins.files.shipped import scenario_file, scenarios

if TYPE_CHECKING:
    from canopen_twins.record import Observer


@contextmanager
def kept(
    options: argparse.Namespace,
    kind: Literal["play", "run"],
    scenario: replay.Scenario | None,
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
    from canopen_twins.record import (  # noqa: PLC0415
        about,
        record,
        trace_file,
    )

    with ExitStack() as stack:
        if options.trace is not None:
            observers.append(stack.enter_context(trace_file(options.trace)))
        if options.record is not None:
            text = None if scenario is None else _content(scenario.file)
            told = about(kind, scenario, participants)
            observers.append(stack.enter_context(record(options.record, told, text)))
        yield observers


def _content(file: Path) -> bytes:
    """Of a scenario, found as `play` finds it."""
    if file.name == str(file) and file.name in scenarios() and not file.exists():
        with scenario_file(file.name) as path:
            return path.read_bytes()
    return file.read_bytes()
