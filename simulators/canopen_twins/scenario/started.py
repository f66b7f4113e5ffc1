"""A scenario that is started while its nodes run already, from a text."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.scenario.load import load
from canopen_twins.scenario.player import Player
from canopen_twins.scenario.scenario import Scenario

START, STOP = "start_scenario", "stop_scenario"
"""What is told of it, beside `bench.twin.ORDERS`; with the first go its name and its text."""


def read_text(name: str, text: str, nodes: Sequence[Node]) -> Scenario:
    """The scenario of a text; settings of its nodes say nothing, as they run already.

    Args:
        name: What it is called in its verdict.
        text: The content of a scenario file.
        nodes: Those there are. A device that a file describes is that of a node.

    Raises:
        UserError: something is wrong with it, or it is about other nodes.
    """

    def find(device: str) -> type[Device]:
        for node in nodes:
            if node.device.files and node.device.files[0].name == Path(device).name:
                return type(node.device)
        if devices.is_file(device):
            raise UserError(f"no node that runs is described by {Path(device).name}")
        return devices.find(device)

    file = Path(name).name or "scenario.yaml"
    with TemporaryDirectory() as folder:
        path = Path(folder) / file
        path.write_text(text, "utf-8", newline="\n")
        try:
            scenario = load(path, find)
        except UserError as mistakes:
            raise UserError(str(mistakes).replace(str(path), file)) from None
    _check(scenario, _by_name(nodes), file)
    return replace(scenario, file=Path(file))


def _by_name(nodes: Sequence[Node]) -> dict[str, Node]:
    """A second device that a fault has put on the bus comes after the one whose name it has."""
    named: dict[str, Node] = {}
    for node in nodes:
        named.setdefault(node.wire.name, node)
    return named


def _check(scenario: Scenario, nodes: dict[str, Node], file: str) -> None:
    for name, spec in scenario.nodes.items():
        if name not in nodes:
            raise UserError(f"{file} is about a {name}; here is {', '.join(nodes)}")
        if not isinstance(nodes[name].device, spec.device):
            raise UserError(f"{file}: {name} is another device here: {nodes[name].device.title}")


def start_now(segment: Segment[Node], scenario: Scenario, text: str) -> Player:
    """Begin a scenario at this moment; who listens to the orders of the segment hears of it."""
    segment.advance_to(segment.clock.now)
    for listener in segment.order_listeners:
        listener("", START, (str(scenario.file), text))
    player = Player(scenario, segment, _by_name(segment.nodes))
    player.start()
    return player


def stop_now(segment: Segment[Node], player: Player) -> None:
    """End a scenario before its time; who listens to the orders of the segment hears of it."""
    segment.advance_to(segment.clock.now)
    for listener in segment.order_listeners:
        listener("", STOP, ())
    player.stop()
    segment.deliver()
