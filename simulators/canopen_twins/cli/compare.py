"""compare: a trace of real devices beside their twins."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

from canopen_twins import devices
from canopen_twins.cli.command import DEVICE, FAILED, OK, Parser, add_device, device_settings
from canopen_twins.cli.tolerances import add_tolerances, tolerances
from canopen_twins.cli.traces import add_trace_options, opened, tell_damage
from canopen_twins.device.device import Device
from canopen_twins.errors import UserError
from canopen_twins.files.whole import write_whole
from canopen_twins.record.compare import Agreement, Comparison, Tolerances
from canopen_twins.record.compare.fit import Fit, Specs
from canopen_twins.record.compare.fit_files import write_fit
from canopen_twins.record.compare.report import as_json, as_page, percent, text
from canopen_twins.record.compare.shown import Shown
from canopen_twins.record.trace_reader import Trace
from canopen_twins.scenario import load_bench
from canopen_twins.scenario.scenario import NodeSpec


def add_compare(parser: Parser) -> None:
    """compare."""
    add_device(parser, f"{DEVICE}, or a bench file: the nodes that the trace is of")
    parser.add_argument("trace", type=Path, metavar="TRACE", help="what was on the bus")
    add_trace_options(parser)
    add_tolerances(parser)
    parser.add_argument("--json", action="store_true", help="the report for programs")
    parser.add_output("--html", "write the report as a page")
    text = "write a bench file with the settings that fit best, and what it needs beside it"
    parser.add_output("--fit", text)
    parser.set_defaults(command=compare)


def compare(options: argparse.Namespace) -> int:
    """0 if all agrees, 1 if something does not."""
    specs = participants(options)
    nodes = {name: spec.create() for name, spec in specs.items()}
    allowed = tolerances(options, nodes.values())
    trace = opened(options, options.trace)
    agreement = _compared(trace, nodes, allowed)
    tell_damage(trace)
    if options.html is not None:
        _write(options.html, as_page(agreement, f"{options.device} beside {options.trace.name}"))
    print(as_json(agreement) if options.json else text(agreement))
    if options.fit is not None:
        _fit(options, specs, trace, allowed, agreement)
    return FAILED if agreement.differences else OK


def _compared(trace: Trace, nodes: Mapping[str, Device], allowed: Tolerances) -> Agreement:
    comparison = Comparison(nodes, allowed)
    for sent in trace:
        comparison.hear(sent.tick, sent.frame)
    return comparison.end()


def _fit(
    options: argparse.Namespace,
    specs: Specs,
    trace: Trace,
    allowed: Tolerances,
    before: Agreement,
) -> None:
    """Write what fits best, and say on stderr what that has brought."""
    best = Fit(specs, trace, allowed).best
    files = write_fit(options.fit, best.specs, best.shown)
    fitted = {name: spec.create() for name, spec in load_bench(options.fit).items()}
    after = _compared(trace, fitted, allowed)
    if after.share < before.share:  # what is beyond the frames that were tried says otherwise
        files = write_fit(options.fit, specs, {name: Shown() for name in specs})
        after = before
    told = f"{percent(after.share)} agree with it, {percent(before.share)} without"
    print(f"{', '.join(map(str, files))}: {told}", file=sys.stderr)


def _write(path: Path, content: str) -> None:
    try:
        write_whole(path, content)
    except OSError as failure:
        raise UserError(f"{path} cannot be written: {failure.strerror}") from failure


def participants(options: argparse.Namespace) -> Specs:
    """The devices by the names of their nodes, and how they are delivered.

    Raises:
        UserError: there is no such device or file, or it cannot be as it is told to be.
    """
    name = options.device
    if not devices.tells_of_device(name) and name.lower().endswith(devices.YAML):
        if device_settings(options):
            raise UserError(f"{name} says all about its nodes: leave --node-id and --set out")
        return load_bench(Path(name))
    return {name: NodeSpec(devices.find(name), device_settings(options))}
