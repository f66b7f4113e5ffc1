"""hub: a CAN bus without vcan, which every process may join."""

import argparse
import json
import logging

from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.hub.server import serve_hub
from canopen_twins.cli.command import Parser, add_parent, catch_signals, parent

log = logging.getLogger(__name__)


def add_hub(parser: Parser) -> None:
    """hub."""
    text = f"where (default: {HubAddress()})"
    parser.add_argument("--listen", default="", metavar="HOST:PORT", help=text)
    add_parent(parser)
    parser.set_defaults(command=hub)


def hub(options: argparse.Namespace) -> int:
    """Serve until SIGTERM or the end of --parent (0), or SIGINT (130)."""
    address, served = HubAddress.parse(options.listen), parent(options)
    if not address.is_loopback:
        log.warning("whoever reaches %s can read and write: there is no password", address)
    with catch_signals() as signals:
        serve_hub(address, lambda: bool(signals) or (served is not None and served.gone), _tell)
        return signals.code


def _tell(address: HubAddress) -> None:
    print(json.dumps({"ready": "hub", "host": address.host, "port": address.port}), flush=True)
