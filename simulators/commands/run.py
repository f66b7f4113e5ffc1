"""A twin on a CAN bus in real time."""

import argparse
import json
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from types import FrameType

import can
from can.cli import create_bus_from_namespace

from simulators import devices, replay
from simulators.commands.chosen import chosen
from simulators.commands.lock import held
from simulators.commands.scenarios import load
from simulators.device import Device
from simulators.errors import UserError
from simulators.memory import Memory
from simulators.segment import Segment
from simulators.serve import serve

OK, FAILED, INTERRUPTED = 0, 1, 130


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM (0), SIGINT (130) or the end of the scenario (0, or 1 if it failed)."""
    with held(options.nvram) if options.nvram else nullcontext(), _signals() as signals:
        return _run(options, signals)


def _run(options: argparse.Namespace, signals: list[int]) -> int:
    segment = Segment()
    scenario = load(options.scenario) if options.scenario else None
    device = _device(options, _delivered(options.device, scenario))
    node = segment.node(device, options.device)
    player = replay.Player(scenario, segment, {options.device: node}) if scenario else None
    if player is not None:
        player.start()
    node.power_on()
    serve(
        segment,
        lambda: _bus(options),
        lambda: bool(signals) or (player is not None and player.done),
        lambda: print(json.dumps(_ready(options, device)), flush=True),
    )
    if player is not None and player.done:
        print(player.verdict)
        return OK if player.verdict.ok else FAILED
    return INTERRUPTED if signal.SIGINT in signals else OK


@contextmanager
def _signals() -> Iterator[list[int]]:
    """SIGINT and SIGTERM as they come: what is under way is finished first."""
    caught: list[int] = []

    def catch(number: int, frame: FrameType | None) -> None:
        caught.append(number)

    before = {number: signal.signal(number, catch) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield caught
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _delivered(name: str, scenario: replay.Scenario | None) -> Mapping[str, object]:
    """The settings a scenario tells its device to have.

    Raises:
        UserError: it is about another one.
    """
    if scenario is None:
        return {}
    if name not in scenario.nodes:
        raise UserError(f"{scenario.file} is about {', '.join(scenario.nodes)}, not about {name}")
    return scenario.nodes[name].settings


def _device(options: argparse.Namespace, delivered: Mapping[str, object]) -> Device:
    device = devices.create(options.device, **{**delivered, **chosen(options)})
    if options.nvram is not None:
        device.memory = Memory(options.nvram)
    return device


def _bus(options: argparse.Namespace) -> can.BusABC:
    """The bus of python-can's own options; what it raises says why there is none."""
    try:
        return create_bus_from_namespace(options)
    except argparse.ArgumentError as failure:
        hint = "" if "interface" in options else " (which one is said with --interface)"
        raise can.CanInitializationError(f"{failure.__cause__}{hint}") from failure


def _ready(options: argparse.Namespace, device: Device) -> dict[str, object]:
    return {
        "ready": options.device,
        "node_id": device.node_id,
        "interface": getattr(options, "interface", None),
        "channel": getattr(options, "channel", None),
    }
