"""How far a device and its twin may be apart, as options say it."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from canopen_twins.cli.command import Parser
from canopen_twins.device.device import Device

if TYPE_CHECKING:
    from canopen_twins.record.compare import Tolerances


def add_tolerances(parser: Parser) -> None:
    """How far a device and its twin may be apart."""
    parser.add_argument("--time", metavar="TIME", help="a time may be off by (default: 5ms)")
    text = "a measured value may be off by: 1%%, or 3 for digits (default: not at all)"
    parser.add_argument("--value", metavar="SHARE", help=text)
    text = "a share of its frames the trace may lack (default: none)"
    parser.add_argument("--lost", metavar="SHARE", help=text)
    text = "YAML: time, value, and objects with tolerances of their own"
    parser.add_argument("--tolerances", type=Path, metavar="FILE", help=text)


def tolerances(options: argparse.Namespace, nodes: Iterable[Device]) -> Tolerances:
    """What the options say; they have the last word.

    Raises:
        UserError: a time or a share that is none, or a mistake in the file.
    """
    # pydantic, which `run` starts without
    from canopen_twins.record.compare import Tolerances  # noqa: PLC0415
    from canopen_twins.record.compare import tolerance_file as files  # noqa: PLC0415

    allowed = Tolerances()
    if options.tolerances is not None:
        allowed = files.read_tolerances(options.tolerances, nodes)
    if options.time is not None:
        allowed = replace(allowed, time=files.time_of(options.time))
    if options.value is not None:
        allowed = replace(allowed, value=files.allowed_of(options.value))
    if options.lost is not None:
        allowed = replace(allowed, lost=files.share_of(options.lost))
    return allowed
