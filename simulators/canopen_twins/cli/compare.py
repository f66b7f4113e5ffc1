"""compare: a trace of real devices beside their twins."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from canopen_twins import devices
from canopen_twins.cli.command import DEVICE, FAILED, OK, Parser, add_device, device_settings
from canopen_twins.cli.traces import add_trace_options, opened, tell_damage
from canopen_twins.device.device import Device
from canopen_twins.errors import UserError
from canopen_twins.record.compare import Comparison
from canopen_twins.record.compare.report import text
from canopen_twins.scenario import load_bench


def add_compare(parser: Parser) -> None:
    """compare."""
    add_device(parser, f"{DEVICE}, or a bench file: the nodes that the trace is of")
    parser.add_argument("trace", type=Path, metavar="TRACE", help="what was on the bus")
    add_trace_options(parser)
    parser.set_defaults(command=compare)


def compare(options: argparse.Namespace) -> int:
    """0 if all agrees, 1 if something does not."""
    comparison = Comparison(participants(options))
    trace = opened(options, options.trace)
    for sent in trace:
        comparison.hear(sent.tick, sent.frame)
    agreement = comparison.end()
    tell_damage(trace)
    print(text(agreement))
    return FAILED if agreement.differences else OK


def participants(options: argparse.Namespace) -> Mapping[str, Device]:
    """The devices by names, with their power off.

    Raises:
        UserError: there is no such device or file, or it cannot be as it is told to be.
    """
    name = options.device
    if not devices.tells_of_device(name) and name.lower().endswith(devices.YAML):
        if device_settings(options):
            raise UserError(f"{name} says all about its nodes: leave --node-id and --set out")
        return {each: spec.create() for each, spec in load_bench(Path(name)).items()}
    return {name: devices.create(name, **device_settings(options))}
