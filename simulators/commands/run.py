"""A twin on a CAN bus in real time."""

import argparse
import json
from collections.abc import Mapping
from contextlib import nullcontext

from simulators import devices, replay
from simulators.commands.bus import Place, place
from simulators.commands.lock import held
from simulators.commands.scenarios import load
from simulators.commands.signals import OK, Wishes, signals
from simulators.device import Device
from simulators.errors import UserError
from simulators.memory import Memory
from simulators.segment import Segment
from simulators.serve import serve

FAILED = 1


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM (0), SIGINT (130) or the end of the scenario (0, or 1 if it failed)."""
    with held(options.nvram) if options.nvram else nullcontext(), signals() as wishes:
        return _run(options, wishes)


def _run(options: argparse.Namespace, wishes: Wishes) -> int:
    bus = place(options)
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
        bus.open,
        lambda: bool(wishes) or (player is not None and player.done),
        lambda: print(json.dumps(_ready(options, device, bus)), flush=True),
    )
    if player is not None and player.done:
        print(player.verdict)
        return OK if player.verdict.ok else FAILED
    return wishes.code


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
    settings = {**delivered, **dict(_pair(text) for text in options.set)}
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


def _ready(options: argparse.Namespace, device: Device, bus: Place) -> dict[str, object]:
    return {"ready": options.device, "node_id": device.node_id, **bus.told}
