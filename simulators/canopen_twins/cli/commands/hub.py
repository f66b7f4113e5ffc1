"""A CAN bus without vcan: a hub that every process may join."""

import argparse
import json
import logging

from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.hub.server import serve_hub
from canopen_twins.cli.commands.signals import signals

log = logging.getLogger(__name__)


def hub(options: argparse.Namespace) -> int:
    """Serve until SIGTERM (0) or SIGINT (130)."""
    address = HubAddress.parse(options.listen)
    if not address.is_loopback:
        log.warning("whoever reaches %s can read and write: there is no password", address)
    with signals() as wishes:
        serve_hub(address, lambda: bool(wishes), _tell)
        return wishes.code


def _tell(address: HubAddress) -> None:
    print(json.dumps({"ready": "hub", "host": address.host, "port": address.port}), flush=True)
