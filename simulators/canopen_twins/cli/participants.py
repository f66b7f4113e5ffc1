"""Who takes part in `run`: one device, the nodes of a scenario, or those of a bench file."""

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path

from canopen_twins import devices
from canopen_twins.cli.check import load
from canopen_twins.cli.command import device_settings
from canopen_twins.device.device import Device
from canopen_twins.device.settings import TimingSettings
from canopen_twins.errors import UserError
from canopen_twins.scenario import Scenario, load_bench
from canopen_twins.scenario.scenario import NodeSpec
from canopen_twins.slave.memory import Memory

OF_ONE_DEVICE = ("node-id", "set", "config", "nvram")


def title(options: argparse.Namespace, scenario: Scenario | None) -> str:
    """As it was called, or the only node of a scenario, or the scenario."""
    if options.device is not None or scenario is None:
        return str(options.device)
    return next(iter(scenario.nodes)) if len(scenario.nodes) == 1 else str(scenario.file)


def participants_of(options: argparse.Namespace, scenario: Scenario | None) -> dict[str, Device]:
    """The devices by the names of their nodes, with their power off.

    Raises:
        UserError: there is no such device or file, or it cannot be as it is told to be.
    """
    name = options.device or ""
    if not devices.tells_of_device(name) and ("/" in name or name.endswith((".yaml", ".yml"))):
        _refuse(options, options.device, (*OF_ONE_DEVICE, "scenario"))
        return {name: _real(spec).create() for name, spec in _of_bench(options.device).items()}
    if scenario is not None:
        return _of_scenario(options, scenario)
    if options.device is None:
        taken = f"; {options.hub} was taken for the hub" if options.hub in devices.names() else ""
        hint = f"say which device, or --scenario with a file that does{taken}"
        raise UserError(f"nothing to run: {hint}")
    spec = _real(NodeSpec(devices.find(options.device), {}))
    return {options.device: _equipped(options, spec)}


def _of_bench(name: str) -> Mapping[str, NodeSpec]:
    try:
        return load_bench(Path(name))
    except UserError as refusal:
        try:
            load(name)
        except UserError:
            raise refusal from None
    raise UserError(f"{name} is a scenario: run --scenario {name}")


def _of_scenario(options: argparse.Namespace, scenario: Scenario) -> dict[str, Device]:
    about = f"{scenario.file} is about {', '.join(scenario.nodes)}"
    if options.device not in (None, *scenario.nodes):
        raise UserError(f"{about}, not about {options.device}")
    if len(scenario.nodes) == 1:
        return {name: _equipped(options, spec) for name, spec in scenario.nodes.items()}
    if options.device is not None:
        raise UserError(f"{about}: leave {options.device} out, and all of them are run")
    _refuse(options, str(scenario.file), OF_ONE_DEVICE)
    return {name: spec.create() for name, spec in scenario.nodes.items()}


def _refuse(options: argparse.Namespace, file: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(options, name.replace("-", "_")):
            raise UserError(f"{file} says all about its nodes: leave --{name} out")


def _real(spec: NodeSpec) -> NodeSpec:
    """With the times of a real device, unless it says others; a scenario is judged by its own."""
    timed = isinstance(spec.device.settings, TimingSettings)
    usual = {"timing": "typical"} if timed else {}
    return NodeSpec(spec.device, {**usual, **spec.settings})


def _equipped(options: argparse.Namespace, spec: NodeSpec) -> Device:
    """With what the command line has to say, which is the last word."""
    device = spec.device(**{**spec.settings, **device_settings(options)})
    if options.nvram is not None:
        device.memory = Memory(options.nvram)
    return device
