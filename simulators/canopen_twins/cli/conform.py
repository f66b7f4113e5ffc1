"""conform: a conformance test of a twin in simulated time, or of a slave on a bus."""

import argparse
from collections.abc import Sequence

from can.cli import add_bus_arguments

from canopen_twins import devices
from canopen_twins.cli.bus import add_bus, named_bus
from canopen_twins.cli.command import FAILED, OK, Parser, add_device, device_settings
from canopen_twins.cli.results import Announcer, add_reports
from canopen_twins.conform import RealBus, Topic, conform, conform_twin, slave_of, topics
from canopen_twins.device.device import Device
from canopen_twins.errors import unknown
from canopen_twins.scenario import Verdict


def add_conform(parser: Parser) -> None:
    """conform."""
    add_device(parser)
    parser.epilog = (
        "Without a bus it is the twin that is tested, in simulated time. On a bus it is the slave"
        " with that node id, which is reset, written to and told to restore its factory settings."
    )
    parser.add_argument(
        "--topic",
        action="append",
        metavar="NUMBER",
        help="play this one only, such as 2.7, or this group; may be said again",
    )
    add_bus(parser)
    add_reports(parser)
    add_bus_arguments(parser)
    parser.set_defaults(command=conformance)


def conformance(options: argparse.Namespace) -> int:
    """Test, and tell; 1 if a topic has failed."""
    announcer, wanted = Announcer(options), _wanted(options.topic)
    device = devices.create(options.device, **device_settings(options))
    on_bus = options.hub is not None or "interface" in options or "channel" in options
    if on_bus:
        verdict = _on_bus(options, device, wanted)
    else:
        verdict = conform_twin(options.device, device, wanted)
    announcer.tell(verdict)
    announcer.end()
    return OK if verdict.ok else FAILED


def _wanted(numbers: Sequence[str] | None) -> Sequence[Topic]:
    """The topics of the command line, all without any; raises `UserError` for one there is not."""
    every = {topic.number: [topic] for topic in topics()}
    for number, (topic,) in [*every.items()]:
        every.setdefault(number.partition(".")[0], []).append(topic)
    for number in numbers or ():
        if number not in every:
            raise unknown("topic", number, every)
    chosen = [topic for number in numbers or () for topic in every[number]]
    return chosen or topics()


def _on_bus(options: argparse.Namespace, device: Device, wanted: Sequence[Topic]) -> Verdict:
    bus = RealBus(named_bus(options).open)
    try:
        return conform(bus, slave_of(options.device, device), wanted)
    finally:
        bus.close()
