"""A twin on a CAN bus in real time."""

import argparse
import json
import signal
from types import FrameType

import can
from can.cli import create_bus_from_namespace

from simulators import devices, replay
from simulators.commands.scenarios import load
from simulators.device import Device
from simulators.errors import UserError
from simulators.memory import Memory
from simulators.segment import Segment
from simulators.serve import serve

FAILED = 1


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM (0), SIGINT (130) or the end of the scenario (0, or 1 if it failed)."""
    device = _device(options)
    segment = Segment()
    node = segment.node(device, options.device)
    player = None
    if options.scenario:
        player = replay.Player(load(options.scenario), segment, {options.device: node})
    stop = _Stop()
    node.power_on()
    if player is not None:
        player.start()
    serve(
        segment,
        lambda: _bus(options),
        lambda: stop.wanted or (player is not None and player.done),
        lambda: print(json.dumps(_ready(options, device)), flush=True),
    )
    if player is None or not player.done:
        return stop.code
    print(player.verdict)
    return 0 if player.verdict.ok else FAILED


class _Stop:
    """SIGINT and SIGTERM, as wishes: what is under way is finished first."""

    def __init__(self) -> None:
        self.wanted = False
        self.code = 0
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.wanted = True
        self.code = 128 + signal.SIGINT if number == signal.SIGINT else 0


def _device(options: argparse.Namespace) -> Device:
    settings: dict[str, object] = dict(_pair(text) for text in options.set)
    if options.node_id is not None:
        settings["node_id"] = options.node_id
    device = devices.create(options.device, **settings)
    if options.nvram is not None:
        device.memory = Memory(options.nvram)
    return device


def _pair(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise UserError(f"--set {text}: write it as KEY=VALUE")
    return key, value


def _bus(options: argparse.Namespace) -> can.BusABC:
    """The bus of python-can's own options; what it raises says why there is none."""
    try:
        return create_bus_from_namespace(options)
    except argparse.ArgumentError as failure:
        raise can.CanInitializationError(str(failure.__cause__)) from failure


def _ready(options: argparse.Namespace, device: Device) -> dict[str, object]:
    return {
        "ready": options.device,
        "node_id": device.node_id,
        "interface": getattr(options, "interface", None),
        "channel": getattr(options, "channel", None),
    }
