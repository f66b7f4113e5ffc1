"""--control: the port by which a run can be touched."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.command import Parser
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.live.orders import Orders
from canopen_twins.live.running import Running, announced

if TYPE_CHECKING:
    from canopen_twins.scenario import Player


def add_control(parser: Parser) -> None:
    """Where the port is, and who may use it."""
    text = "a port for HTTP by which the twins can be touched (default: a free one of 127.0.0.1)"
    parser.add_argument("--control", nargs="?", const="", metavar="HOST:PORT", help=text)
    text = "what every request has to bring; needed beyond this machine"
    parser.add_argument("--control-token", metavar="TOKEN", default="", help=text)


class Control(NamedTuple):
    """What a run has of its port."""

    orders: Orders
    told: Mapping[str, object]
    """For the ready line."""


@contextmanager
def controlled(
    options: argparse.Namespace, segment: Segment[Node], player: Player | None, title: str
) -> Iterator[Control]:
    """The port of the options, if they want one; the user finds it by the title.

    Raises:
        UserError: there can be none.
    """
    orders = Orders()
    if options.control is None:
        if options.control_token:
            raise UserError("--control-token is for a port: say --control, too")
        yield Control(orders, {})
        return
    from canopen_twins.live.control import control_port  # noqa: PLC0415 - most runs need none

    address = HubAddress.parse(options.control, port=0)
    with control_port(segment, orders, address, options.control_token, player) as found:
        running = Running(title, f"http://{found}", options.control_token)
        with announced(running):
            yield Control(orders, {"control": running.address})
