"""Who takes part in `run`: one device, the nodes of a scenario, or those of a bench file."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from canopen_twins import devices
from canopen_twins.cli.command import device_settings
from canopen_twins.device.device import Device
from canopen_twins.device.settings import TimingSettings
from canopen_twins.errors import UserError
from canopen_twins.slave.memory import Memory

if TYPE_CHECKING:
    from canopen_twins.scenario import Scenario
    from canopen_twins.scenario.scenario import NodeSpec

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
        nodes = _of_bench(options.device).items()
        return {
            name: spec.device(**{**_timed(spec.device), **spec.settings}) for name, spec in nodes
        }
    if scenario is not None:
        return _of_scenario(options, scenario)
    if options.device is None:
        taken = f"; {options.hub} was taken for the hub" if options.hub in devices.names() else ""
        hint = f"say which device, or --scenario with a file that does{taken}"
        raise UserError(f"nothing to run: {hint}")
    device = devices.find(options.device)
    return {options.device: _equipped(options, device, _timed(device))}


def _of_bench(name: str) -> Mapping[str, NodeSpec]:
    # who names a device has no file, and starts without what reads one
    from canopen_twins.cli.scenario_file import load  # noqa: PLC0415
    from canopen_twins.scenario import load_bench  # noqa: PLC0415

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
        return {
            name: _equipped(options, spec.device, spec.settings)
            for name, spec in scenario.nodes.items()
        }
    if options.device is not None:
        raise UserError(f"{about}: leave {options.device} out, and all of them are run")
    _refuse(options, str(scenario.file), OF_ONE_DEVICE)
    return {name: spec.create() for name, spec in scenario.nodes.items()}


def _refuse(options: argparse.Namespace, file: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(options, name.replace("-", "_")):
            raise UserError(f"{file} says all about its nodes: leave --{name} out")


def _timed(device: type[Device]) -> Mapping[str, object]:
    """The times of a real device, unless somebody says others; a scenario is judged by its own."""
    return {"timing": "typical"} if isinstance(device.settings, TimingSettings) else {}


def _equipped(
    options: argparse.Namespace, kind: type[Device], settings: Mapping[str, object]
) -> Device:
    """With what the command line has to say, which is the last word."""
    device = kind(**{**settings, **device_settings(options)})
    if options.nvram is not None:
        device.memory = Memory(options.nvram)
    return device
