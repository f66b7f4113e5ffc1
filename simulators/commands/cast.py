"""Who is run: one device with its options, or everybody of a bench file."""

import argparse
from collections.abc import Mapping
from pathlib import Path

from simulators import devices, replay
from simulators.commands.chosen import chosen
from simulators.device import Device
from simulators.errors import UserError
from simulators.memory import Memory

OF_ONE_DEVICE = ("node-id", "set", "config", "scenario", "nvram")


def cast(options: argparse.Namespace, scenario: replay.Scenario | None) -> dict[str, Device]:
    """The devices by the names of their nodes, with their power off.

    Raises:
        UserError: there is no such device or file, or it cannot be as it is told to be.
    """
    if not _is_file(options.device):
        return {options.device: _device(options, _delivered(options.device, scenario))}
    for name in OF_ONE_DEVICE:
        if getattr(options, name.replace("-", "_")):
            raise UserError(f"{options.device} says all about its nodes: leave --{name} out")
    bench = replay.load_bench(Path(options.device))
    return {name: spec.create() for name, spec in bench.items()}


def _is_file(name: str) -> bool:
    return "/" in name or name.endswith((".yaml", ".yml"))


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
