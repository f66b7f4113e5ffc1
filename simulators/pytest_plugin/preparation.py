"""Imports and reads, before the first test, what the first twin of a process needs."""

from __future__ import annotations

from collections.abc import Iterable, Set
from contextlib import suppress
from importlib import import_module

MODULES = {
    "canopen_bench": ("simulators.report",),
    "canopen_device": ("simulators.served",),
    "canopen_scenario": ("simulators.scenario_bench", "simulators.replay.reading.scenario"),
    "canopen_simulated_time": ("simulators.simulated_time",),
}


def prepare(uses: Iterable[Set[str]]) -> None:
    """For tests that use these fixtures: those of devices tell which one, others may want any."""
    from simulators import Bench, devices  # noqa: PLC0415

    known = set(devices.names())
    for fixture in set().union(*uses) & MODULES.keys():
        for module in MODULES[fixture]:
            import_module(module)
    wanted = set().union(*(names & known or known for names in uses))
    for name in sorted(wanted):
        with suppress(Exception):  # a device is broken: whoever asks for it is told
            _ = Bench(name).sdo
