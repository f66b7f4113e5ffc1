"""Which settings and objects of a device a hunt changes, and to what: as they are declared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import islice
from math import isfinite
from typing import Any, Literal, get_args, get_origin, get_type_hints

from canopen_twins.device.device import Device
from canopen_twins.device.settings import About, about
from canopen_twins.scenario import Scenario
from canopen_twins.scenario.actions import Set
from canopen_twins.slave.dictionary import Objects

MOST_MEASURED = 8
TIMINGS: Mapping[str, Sequence[Any]] = {
    "timing": ("typical", "worst"),
    "boot_time": (0.3, 3.0),
    "answer_time": (0.002, 0.05),
    "store_time": (0.1, 0.8),
    "store_busy": ("refuses",),
    "busy_request": ("waits",),
}
"""Of settings that every device has, worth trying at delivery."""


def changes(scenario: Scenario, node: str, device: Device) -> Iterator[tuple[str, Any]]:
    """What may change while it runs, by name, and to what."""
    for name, told, values in _settings(device):
        if told.live:
            yield from ((name, value) for value in _settable(scenario, name, values))
    for name, values in _objects(scenario, node, device):
        yield from ((name, value) for value in _settable(scenario, name, values))


def deliveries(scenario: Scenario, device: Device) -> Iterator[tuple[str, Any]]:
    """How it may be delivered."""
    for name, told, _ in _settings(device):
        if not told.live:
            tried = _settable(scenario, name, TIMINGS.get(name, ()))
            yield from ((name, value) for value in tried)


def _objects(scenario: Scenario, node: str, device: Device) -> Iterator[tuple[str, Sequence[Any]]]:
    """What is measured, at its ends: a sensor breaks, a sign or a carry is forgotten.

    What the steps of the contract set is theirs.
    """
    known = Objects(device.dictionary())
    theirs = {
        known.find(name).qualname
        for step in scenario.steps
        if isinstance(step.action, Set) and step.node == node
        for name in step.action.settings
        if name in known
    }
    ends = {
        name: (high, low)
        for name, (low, high) in islice(device.ranges.items(), MOST_MEASURED)
        if known.find(name).qualname not in theirs
    }
    settings = {entry.name for entry in fields(device.settings)}
    chosen = [name for name in scenario.space.settings if name not in settings]
    for name in {**dict.fromkeys(filter(device.knows, chosen)), **ends}:
        yield name, ends.get(name, ())


def _settable(scenario: Scenario, name: str, values: Sequence[Any]) -> Sequence[Any]:
    """Those of the file; what is declared is left out where the file names faults alone."""
    said = scenario.space
    return said.settings.get(name, values if said.faults is None else ())


def _settings(device: Device) -> Iterator[tuple[str, About, Sequence[Any]]]:
    """Every setting, with values that its declaration tells."""
    types = get_type_hints(type(device.settings))
    for entry in fields(device.settings):
        told, kind = about(entry), types[entry.name]
        values: Sequence[Any] = ()
        if get_origin(kind) is Literal:
            values = get_args(kind)
        elif kind is bool:
            values = (False, True)
        elif kind is float and isfinite(told.low) and isfinite(told.high):
            values = (told.low, told.high)
        current = getattr(device.settings, entry.name)
        yield entry.name, told, [each for each in values if each != current]
