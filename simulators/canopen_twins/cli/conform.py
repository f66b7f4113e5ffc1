"""conform: a conformance test of a twin in simulated time, or of a slave on a bus."""

import argparse

from can.cli import add_bus_arguments

from canopen_twins import devices
from canopen_twins.cli.bus import add_bus, named_bus
from canopen_twins.cli.command import FAILED, OK, Parser, add_device, device_settings
from canopen_twins.cli.results import Announcer, add_reports
from canopen_twins.conform import RealBus, conform, conform_twin, slave_of
from canopen_twins.device.device import Device
from canopen_twins.scenario import Verdict


def add_conform(parser: Parser) -> None:
    """conform."""
    add_device(parser)
    parser.epilog = (
        "Without a bus it is the twin that is tested, in simulated time. On a bus it is the slave"
        " with that node id, which is reset, written to and told to restore its factory settings."
    )
    add_bus(parser)
    add_reports(parser)
    add_bus_arguments(parser)
    parser.set_defaults(command=conformance)


def conformance(options: argparse.Namespace) -> int:
    """Test, and tell; 1 if a topic has failed."""
    announcer = Announcer(options)
    device = devices.create(options.device, **device_settings(options))
    on_bus = options.hub is not None or "interface" in options or "channel" in options
    verdict = _on_bus(options, device) if on_bus else conform_twin(options.device, device)
    announcer.tell(verdict)
    announcer.end()
    return OK if verdict.ok else FAILED


def _on_bus(options: argparse.Namespace, device: Device) -> Verdict:
    bus = RealBus(named_bus(options).open)
    try:
        return conform(bus, slave_of(options.device, device))
    finally:
        bus.close()
