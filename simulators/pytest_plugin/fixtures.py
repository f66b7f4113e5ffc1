"""The fixtures: benches, twins in real time, and scenarios that a test lives through.

`canopen_bench` makes benches in simulated time, `canopen_simulated_time` takes an unmodified master
there, `canopen_scenario` brings a scenario along, and `canopen_device` serves twins on a python-can
bus in real time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import pytest

if TYPE_CHECKING:
    from simulators.bench import Bench
    from simulators.device import Device
    from simulators.scenario_bench import ScenarioBench
    from simulators.served import Served

INTERFACE, CHANNEL = "canopen_interface", "canopen_channel"

SHOWN = pytest.StashKey[list[Callable[[], str]]]()
"""What a failing test has to show: functions that tell it, so that passing tests pay nothing."""
TOLD = pytest.StashKey[list["ScenarioBench"]]()
"""The scenarios of a test, which is over when they are."""


AnyBench = TypeVar("AnyBench", bound="Bench")


class BenchFactory:
    """Makes benches, and lets a failing test show what happened on them."""

    def __init__(self, shown: list[Callable[[], str]]) -> None:
        self._shown = shown

    def __call__(self, device: str, **settings: object) -> Bench:
        """A bench with one twin: `canopen_bench("topcon", node_id=5, load="resistor 4")`."""
        from simulators.bench import Bench  # noqa: PLC0415

        return self.watched(Bench(device, **settings))

    def of(self, nodes: dict[str, tuple[str, int] | Device]) -> Bench:
        """A bench with several twins, as `Bench.of`."""
        from simulators.bench import Bench  # noqa: PLC0415

        return self.watched(Bench.of(nodes))

    def watched(self, bench: AnyBench) -> AnyBench:
        """The same bench; a test that fails shows it."""
        from simulators.report import scene  # noqa: PLC0415

        self._shown.append(lambda: scene(bench.trace, bench.segment.nodes))
        return bench


@pytest.fixture
def canopen_bench(request: pytest.FixtureRequest) -> BenchFactory:
    """Makes benches: `canopen_bench("topcon", node_id=5)`; there is nothing to close."""
    return BenchFactory(request.node.stash.setdefault(SHOWN, []))


@pytest.fixture
def canopen_scenario(
    request: pytest.FixtureRequest, canopen_bench: BenchFactory
) -> Callable[[str], ScenarioBench]:
    """`canopen_scenario("trip.yaml")`: a bench on which this scenario is played meanwhile.

    The file lies beside the test, or is one of those that are shipped. When the test is over, the
    rest is played; it fails if the verdict is not PASS, and is skipped if it is SKIP.
    """
    from simulators.pytest_plugin.scenarios import beside  # noqa: PLC0415
    from simulators.scenario_bench import ScenarioBench  # noqa: PLC0415

    def begin(file: str) -> ScenarioBench:
        bench = canopen_bench.watched(ScenarioBench(beside(request.path, file)))
        request.node.stash.setdefault(TOLD, []).append(bench)
        return bench

    return begin


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
            shown.append(served.report)
            return running.enter_context(served)

        yield start


def _option(config: pytest.Config, name: str) -> Any:
    return config.getoption(name) or config.getini(name)
