"""The pytest plugin: twins as fixtures, and `*.twin.yaml` files as tests.

No CAN is imported before the end of a collection that has found something to use it for.
"""

from __future__ import annotations

from collections.abc import Generator
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import pytest

from simulators.pytest_plugin.fixtures import (
    CHANNEL,
    INTERFACE,
    SHOWN,
    TOLD,
    BenchFactory,
    canopen_bench,
    canopen_device,
    canopen_scenario,
    canopen_simulated_time,
)
from simulators.pytest_plugin.scenarios import ScenarioFile, note, settle

if TYPE_CHECKING:
    from simulators.bench import Bench

__all__ = ["canopen_bench", "canopen_device", "canopen_scenario", "canopen_simulated_time"]

DEVICES = Path(__file__).parents[1] / "devices"
GROUP = "canopen_twins.devices"  # that of simulators.devices, which imports CAN
FIXTURES = __all__
SUFFIXES = (".twin.yaml", ".twin.yml")


def pytest_addoption(parser: pytest.Parser) -> None:
    """The bus of `canopen_device`."""
    group = parser.getgroup("canopen", "CANopen twins")
    for name, text in (
        (INTERFACE, "python-can interface of `canopen_device` (default: virtual)"),
        (CHANNEL, "its channel (default: one of its own for each test)"),
    ):
        group.addoption(f"--{name.replace('_', '-')}", dest=name, default=None, help=text)
        parser.addini(name, text)


def pytest_configure(config: pytest.Config) -> None:
    """A fixture for each device that is there."""
    fixtures = ModuleType("canopen_twins_devices")
    shipped = (package.parent.name for package in DEVICES.glob("*/__init__.py"))
    for name in sorted({*shipped, *(each.name for each in entry_points(group=GROUP))}):
        setattr(fixtures, name, _device_fixture(name))
    config.pluginmanager.register(fixtures, fixtures.__name__)


def _device_fixture(name: str) -> object:
    @pytest.fixture(name=name)
    def bench(canopen_bench: BenchFactory) -> Bench:
        return canopen_bench(name)

    bench.__doc__ = f"A bench with one {name} on it, in simulated time."
    return bench


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """A scenario is a test."""
    is_scenario = file_path.name.endswith(SUFFIXES)
    return ScenarioFile.from_parent(parent, path=file_path) if is_scenario else None


def pytest_collection_finish(session: pytest.Session) -> None:
    """What a first twin has to import and to read is there before the first test."""
    uses = [set(getattr(item, "fixturenames", ())) for item in session.items]
    wanted = [names for names in uses if not names.isdisjoint(FIXTURES)]
    if wanted and not session.config.option.collectonly:
        from simulators.pytest_plugin.preparation import prepare  # noqa: PLC0415

        prepare(wanted)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """A test is over when its scenarios are: what they expect counts as what it asserts."""
    try:
        result = yield
    except (Exception, pytest.fail.Exception):
        note(item)
        raise
    settle(item)
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A failing test shows what happened on its buses."""
    report = yield
    if report.failed:
        for show in item.stash.get(SHOWN, []):
            report.sections.append(("CANopen: last frames and devices", show()))
        for told in item.stash.get(TOLD, []):
            report.sections.append(("CANopen: the scenario so far", str(told.verdict)))
    return report
