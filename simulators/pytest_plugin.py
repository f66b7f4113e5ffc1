"""pytest fixtures for who tests master software; no CAN is imported before one is used.

`canopen_bench` makes benches in simulated time, `canopen_simulated_time` takes an unmodified master
there, `canopen_device` serves twins on a python-can bus in real time, and every device has a
fixture of its own name: a bench with this twin on it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from simulators.bench import Bench
    from simulators.device import Device
    from simulators.served import Served

INTERFACE, CHANNEL = "canopen_interface", "canopen_channel"
DEVICES = Path(__file__).parent / "devices"
GROUP = "canopen_twins.devices"  # that of simulators.devices, which imports CAN

SHOWN = pytest.StashKey[list[Callable[[], str]]]()
"""What a failing test has to show: functions that tell it, so that passing tests pay nothing."""


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


class BenchFactory:
    """Makes benches, and lets a failing test show what happened on them."""

    def __init__(self, shown: list[Callable[[], str]]) -> None:
        self._shown = shown

    def __call__(self, device: str, **settings: object) -> Bench:
        """A bench with one twin: `canopen_bench("topcon", node_id=5, load="resistor 4")`."""
        from simulators.bench import Bench  # noqa: PLC0415

        return self._watched(Bench(device, **settings))

    def of(self, nodes: dict[str, tuple[str, int] | Device]) -> Bench:
        """A bench with several twins, as `Bench.of`."""
        from simulators.bench import Bench  # noqa: PLC0415

        return self._watched(Bench.of(nodes))

    def _watched(self, bench: Bench) -> Bench:
        from simulators.report import device_state, last_frames  # noqa: PLC0415

        def story() -> str:
            nodes = bench.segment.nodes
            return "\n".join([last_frames(bench.trace, nodes), *map(device_state, nodes)])

        self._shown.append(story)
        return bench


@pytest.fixture
def canopen_bench(request: pytest.FixtureRequest) -> BenchFactory:
    """Makes benches: `canopen_bench("topcon", node_id=5)`; there is nothing to close."""
    return BenchFactory(request.node.stash.setdefault(SHOWN, []))


@pytest.fixture
def canopen_simulated_time() -> Iterator[Callable[..., None]]:
    """`canopen_simulated_time(bench, "my_master")`: simulated time until the end of the test.

    What is a bench's, canopen's and the named modules' waits no more in real time: see
    `simulators.simulated_time.simulated_time`.
    """
    from contextlib import ExitStack  # noqa: PLC0415

    from simulators.simulated_time import simulated_time  # noqa: PLC0415

    with ExitStack() as entered:

        def enter(bench: Bench, *modules: ModuleType | str) -> None:
            entered.enter_context(simulated_time(bench, *modules))

        yield enter


@pytest.fixture
def canopen_device(request: pytest.FixtureRequest) -> Iterator[Callable[..., Served]]:
    """Serves twins in real time: `canopen_device("topcon", node_id=5)` has booted when it returns.

    The bus is that of `--canopen-interface` and `--canopen-channel`, or of the ini keys
    `canopen_interface` and `canopen_channel`; a channel of its own on `virtual` otherwise. A bug in
    a twin fails the test.
    """
    from contextlib import ExitStack  # noqa: PLC0415

    from simulators.served import Served  # noqa: PLC0415

    shown = request.node.stash.setdefault(SHOWN, [])
    bus = {
        "interface": _option(request.config, INTERFACE) or "virtual",
        "channel": _option(request.config, CHANNEL) or request.node.nodeid,
    }
    with ExitStack() as running:

        def start(device: str, **settings: object) -> Served:
            served = Served(device, settings, bus)
            shown.append(served.story)
            return running.enter_context(served)

        yield start


def _option(config: pytest.Config, name: str) -> Any:
    return config.getoption(name) or config.getini(name)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A failing test shows what happened on its buses."""
    report = yield
    if report.failed:
        for story in item.stash.get(SHOWN, []):
            report.sections.append(("CANopen: last frames and devices", story()))
    return report
