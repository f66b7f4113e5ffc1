"""decode: a trace in words, with the names of dictionaries where there are any."""

import argparse
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from canopen_twins import devices
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.command import OK, Parser
from canopen_twins.cli.traces import add_trace_options, opened, tell_damage
from canopen_twins.device.node import Node, wait_for_boot
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.errors import UserError
from canopen_twins.faults import connect

REMEMBERED = 1 << 16  # frames; a trace has many that are the same


def add_decode(parser: Parser) -> None:
    """decode."""
    parser.add_argument("trace", type=Path, metavar="TRACE", help="what was on the bus")
    text = "a node of it: 5=drive.eds, 6=topcon; without a node id that of the file"
    parser.add_argument(
        "--eds", action="append", default=[], metavar="[ID=]DEVICE", help=text, dest="nodes"
    )
    add_trace_options(parser)
    parser.set_defaults(command=decode)


def decode(options: argparse.Namespace) -> int:
    """Every frame with its seconds from the first one on."""
    words = lru_cache(REMEMBERED)(Decoder(_nodes(options.nodes)).words)
    trace, first = opened(options, options.trace), None
    for tick, frame in trace:
        first = tick if first is None else first
        print(f"{(tick - first) / MICROSECONDS:12.6f}  {frame!s:21}  {words(frame)}".rstrip())
    tell_damage(trace)
    return OK


def _nodes(texts: Sequence[str]) -> Sequence[Node]:
    """Booted, so that they have their dictionaries.

    Raises:
        UserError: no such device, or a node id that is none.
    """
    segment: Segment[Node] = Segment()
    for text in texts:
        number, equals, name = text.partition("=")
        if equals and not number.isdecimal():
            raise UserError(f"--eds {text}: write it as 5=DEVICE")
        given = {"node_id": int(number)} if equals else {}
        connect(segment, devices.create(name if equals else text, **given), text)
    for node in segment.nodes:
        node.power_on()
    wait_for_boot(segment.nodes, segment.advance)
    return segment.nodes
