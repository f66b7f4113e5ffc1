"""`*.twin.yaml` as tests, fixtures with twins, and verdicts as pytest tells them.

A scenario is played in the set-up of its test. What it says of who is tested is the outcome of the
test itself; that it could not be carried out is an error, and one in the set-up is what pytest and
CI tell apart from a failure.

pytest loads this in every run, so whatever needs CAN is imported when somebody asks for it, as the
names of `canopen_twins` are.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Set
from contextlib import ExitStack, suppress
from importlib import import_module
from importlib.metadata import entry_points
from itertools import count
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import pytest

import canopen_twins
from canopen_twins.errors import UserError

if TYPE_CHECKING:
    from canopen_twins import Bench, Device, Scenario, Verdict
    from canopen_twins.bus.hub.protocol import HubAddress
    from canopen_twins.devices import What
    from canopen_twins.hunt.report import Report
    from canopen_twins.live.master_process import BusPlace
    from canopen_twins.live.twin import LiveTwin
    from canopen_twins.live.twin_process import TwinProcess
    from canopen_twins.scenario.play import ScenarioBench

__all__ = [
    "canopen_bench",
    "canopen_device",
    "canopen_hub",
    "canopen_hunt",
    "canopen_process",
    "canopen_scenario",
    "canopen_simulated_time",
    "hub_of_session",
]

AnyBench = TypeVar("AnyBench", bound="Bench")

SUFFIXES = (".twin.yaml", ".twin.yml")
INTERFACE, CHANNEL = "canopen_interface", "canopen_channel"
FINDS = "canopen_finds"
DEVICES = Path(__file__).parent / "devices"
GROUP = "canopen_twins.devices"  # that of canopen_twins.devices, which imports CAN
MODULES = {
    "canopen_bench": ("canopen_twins.diagnosis.report",),
    "canopen_device": ("canopen_twins.live.twin",),
    "canopen_hunt": ("canopen_twins.hunt.search",),
    "canopen_process": ("canopen_twins.live.twin_process",),
    "canopen_scenario": ("canopen_twins.scenario.play", "canopen_twins.scenario.compile"),
    "canopen_simulated_time": ("canopen_twins.bench.simulated_time",),
}
"""What the first test with a fixture would have to import."""

REAL_BUS = (
    "The bench of this test is on no bus of python-can. To have a master connect to it, whatever"
    " interface that asks for: canopen_simulated_time(bench, 'my_master')"
)

OURS = "canopen_"  # what the names of our properties begin with
SHOWN = pytest.StashKey[list[Callable[[], str]]]()
"""What a failing test has to show: functions that tell it, so that passing tests pay nothing."""
TOLD = pytest.StashKey[list["ScenarioBench"]]()
"""The scenarios of a test, which is over when they are."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """The bus of `canopen_device`, and the finds of `canopen_hunt`."""
    group = parser.getgroup("canopen", "CANopen twins")
    for name, text in (
        (
            INTERFACE,
            "python-can interface of `canopen_device` (default: virtual) and of `canopen_process`"
            " (default: a hub)",
        ),
        (CHANNEL, "its channel (default: one of its own for each test)"),
        (FINDS, "where `canopen_hunt` keeps finds, and takes those of before (default: nowhere)"),
    ):
        group.addoption(f"--{name.replace('_', '-')}", dest=name, default=None, help=text)
        parser.addini(name, text)


def pytest_configure(config: pytest.Config) -> None:
    """A fixture for each device that is there."""
    fixtures = ModuleType("canopen_twins_devices")
    folders = (package.parent.name for package in DEVICES.glob("*/__init__.py"))
    shipped = (name for name in folders if name != "eds")  # which is of files
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
    wanted = [names for names in uses if not names.isdisjoint(MODULES)]
    if wanted and not session.config.option.collectonly:
        prepare(wanted)


def prepare(uses: Iterable[Set[str]]) -> None:
    """For tests that use these fixtures: those of devices tell which one, others may want any."""
    from canopen_twins import devices  # noqa: PLC0415

    known = set(devices.names())
    for fixture in set().union(*uses) & MODULES.keys():
        for module in MODULES[fixture]:
            import_module(module)
    wanted = set().union(*(names & known or known for names in uses))
    for name in sorted(wanted):
        with suppress(Exception):  # a device is broken: whoever asks for it is told
            _ = canopen_twins.Bench(name).sdo


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """An attempt knows nothing of those before it, as there are with pytest-rerunfailures."""
    if SHOWN in item.stash:
        del item.stash[SHOWN]
    if TOLD in item.stash:
        del item.stash[TOLD]
    others = [each for each in item.user_properties if not each[0].startswith(OURS)]
    item.user_properties[:] = others


@pytest.hookimpl(trylast=True)
def pytest_runtest_call(item: pytest.Item) -> None:
    """A test is over when its scenarios are: what they expect counts as what it asserts.

    It is the last to be called and no wrapper: those of today are unknown to pluggy below 1.2.
    """
    settle(item)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, Any, None]:
    """A failing test shows what happened on its buses."""
    error = None if call.excinfo is None else call.excinfo.value
    if call.when == "call" and isinstance(error, (Exception, pytest.fail.Exception)):
        note(item)
        if SHOWN in item.stash and opened_a_real_bus(error):
            error.add_note(REAL_BUS)
    report = (yield).get_result()
    if report.failed:
        for show in item.stash.get(SHOWN, []):
            report.sections.append(("CANopen: last frames and devices", show()))
        for told in item.stash.get(TOLD, []):
            report.sections.append(("CANopen: the scenario so far", str(told.verdict)))


def opened_a_real_bus(error: BaseException) -> bool:
    """Whether an exception is that of python-can's interfaces, which have no such bus."""
    if not isinstance(error, OSError) and type(error).__module__ != "can.exceptions":
        return False
    frames = traceback.walk_tb(error.__traceback__)
    modules = [frame.f_globals.get("__name__", "") for frame, _ in frames]
    return any(name.startswith("can.interface") for name in modules)


class BenchFactory:
    """Makes benches, and lets a failing test show what happened on them."""

    def __init__(self, shown: list[Callable[[], str]], test: Path) -> None:
        self._shown = shown
        self._test = test

    def __call__(self, device: What, **settings: object) -> Bench:
        """A bench with one twin: `canopen_bench("topcon", node_id=5, load="resistor 4")`."""
        return self.watched(canopen_twins.Bench(file_beside(self._test, device), **settings))

    def of(self, nodes: Mapping[str, tuple[What, int] | Device]) -> Bench:
        """A bench with several twins, as `Bench.of`."""
        found = {
            name: (file_beside(self._test, what[0]), what[1]) if isinstance(what, tuple) else what
            for name, what in nodes.items()
        }
        return self.watched(canopen_twins.Bench.of(found))

    def watched(self, bench: AnyBench) -> AnyBench:
        """The same bench; a test that fails shows it."""
        from canopen_twins.diagnosis.report import scene  # noqa: PLC0415

        self._shown.append(lambda: scene(bench.trace, bench.segment.nodes))
        return bench


@pytest.fixture
def canopen_bench(request: pytest.FixtureRequest) -> BenchFactory:
    """Makes benches: `canopen_bench("topcon", node_id=5)`; there is nothing to close.

    `canopen_bench("drive.eds")` takes the file beside the test, or that of a path from here, and
    `canopen_bench(Drive)` a class.
    """
    return BenchFactory(request.node.stash.setdefault(SHOWN, []), request.path)


@pytest.fixture
def canopen_scenario(
    request: pytest.FixtureRequest, canopen_bench: BenchFactory
) -> Callable[[str], ScenarioBench]:
    """`canopen_scenario("trip.yaml")`: a bench on which this scenario is played meanwhile.

    The file lies beside the test, or is one of those that are shipped. When the test is over, the
    rest is played; it fails if the verdict is not PASS, and is skipped if it is SKIP.
    """
    from canopen_twins.scenario.play import ScenarioBench  # noqa: PLC0415

    def begin(file: str) -> ScenarioBench:
        bench = canopen_bench.watched(ScenarioBench(beside(request.path, file)))
        request.node.stash.setdefault(TOLD, []).append(bench)
        return bench

    return begin


@pytest.fixture
def canopen_simulated_time(request: pytest.FixtureRequest) -> Iterator[Callable[..., None]]:
    """`canopen_simulated_time(bench, "my_master")`: simulated time until the end of the test.

    What is a bench's, canopen's and the named modules' waits no more in real time: see
    `canopen_twins.simulated_time`, which also has the limits that may be given.
    """
    with ExitStack() as entered:

        def enter(bench: Bench, *modules: ModuleType | str, **limits: float) -> None:
            context = canopen_twins.simulated_time(
                bench, *modules, watched=[request.module], **limits
            )
            entered.enter_context(context)

        yield enter


@pytest.fixture
def canopen_hunt(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., Report]:
    """`canopen_hunt("contract.yaml", my_master.main, seconds=10)`: fails with what it finds.

    The contract lies beside the test; the master is a function, its name as in `--master`, or that
    of the file. Finds are written to `--canopen-finds`, or to `finds` beside the test, if there is
    one; those of before are played first. It gives a report of the hunt.
    """
    from canopen_twins.hunt.report import lines  # noqa: PLC0415
    from canopen_twins.hunt.search import hunt, lost  # noqa: PLC0415
    from canopen_twins.hunt.workers import workers  # noqa: PLC0415

    def search(contract: str, master: Callable[..., object] | str = "", **budget: Any) -> Report:
        beside_test = request.path.parent
        kept = _option(request.config, FINDS)
        folder = Path(kept) if kept else beside_test / "finds"
        name = master if isinstance(master, str) else f"{master.__module__}:{master.__qualname__}"
        try:
            with workers(1, lost) as play:
                report = hunt(
                    _from_here(beside_test / contract),
                    name,
                    folder=_from_here(folder) if kept or folder.is_dir() else tmp_path,
                    play=play,
                    **budget,
                )
        except UserError as mistakes:
            told = str(mistakes)
        else:
            if report.ok:
                return report
            files = [f"{each.file}:\n{each.text}" for each in (*report.known, *report.finds)]
            told = "\n".join([*lines(report), *files])
        pytest.fail(told, pytrace=False)

    return search


def _from_here(path: Path) -> Path:
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


@pytest.fixture
def canopen_device(request: pytest.FixtureRequest) -> Iterator[Callable[..., LiveTwin]]:
    """Twins in real time: `canopen_device("topcon", node_id=5)` has booted when it returns.

    A file or a class may stand for the name, as with `canopen_bench`. It gives a `Twin`, with
    `bus`: what to open to be on the same bus. The bus is that of `--canopen-interface` and
    `--canopen-channel`, or of the ini keys `canopen_interface` and `canopen_channel`; a channel of
    its own on `virtual` otherwise. A bug in a twin fails the test.
    """
    from canopen_twins.live.twin import LiveTwin  # noqa: PLC0415

    shown = request.node.stash.setdefault(SHOWN, [])
    bus = {
        "interface": _option(request.config, INTERFACE) or "virtual",
        "channel": _option(request.config, CHANNEL) or request.node.nodeid,
    }
    with ExitStack() as running:

        def start(device: What, **settings: object) -> LiveTwin:
            twin = LiveTwin(file_beside(request.path, device), settings, bus)
            shown.append(twin.scene)
            return running.enter_context(twin)

        yield start


@pytest.fixture(scope="session", name="_canopen_hub")
def hub_of_session() -> Iterator[tuple[HubAddress, Iterator[int]]]:
    """A hub of this process of pytest on a free port, and numbers for the buses of its tests."""
    from canopen_twins.live.hub_process import hub_process  # noqa: PLC0415

    with hub_process() as address:
        yield address, count(1)


@pytest.fixture
def canopen_hub(_canopen_hub: tuple[HubAddress, Iterator[int]]) -> BusPlace:
    """A bus of its own on a hub, for masters and twins in any process: see `canopen_process`.

    `can.Bus(**canopen_hub.options)` is on it; a process finds it with `canopen_hub.environment`, or
    with what `canopen_hub.hub` (HOST:PORT) and `canopen_hub.channel` say. The hub is there for all
    tests of a process of pytest, so that each worker of pytest-xdist has one.
    """
    from canopen_twins.live.master_process import BusPlace  # noqa: PLC0415

    address, numbers = _canopen_hub
    return BusPlace.on_hub(address, f"test{next(numbers)}")


@pytest.fixture
def canopen_process(request: pytest.FixtureRequest) -> Iterator[Callable[..., TwinProcess]]:
    """Twins in a process of their own: `canopen_process("topcon", node_id=5)` has booted.

    What stands for the name, and the settings, are as with `canopen_device`; `scenario="trip.yaml"`
    is played meanwhile, with or without a name. It gives `bus`, what to open to be on the same bus;
    `wait()`, the exit code when the scenario is over; `end()`, `output` and `errors`. The bus is
    that of `canopen_hub`, unless `--canopen-interface` or its ini key says otherwise. The process
    ends with the test, however that ends.
    """
    from canopen_twins.live.master_process import BusPlace  # noqa: PLC0415
    from canopen_twins.live.twin_process import TwinProcess  # noqa: PLC0415

    interface = _option(request.config, INTERFACE)
    if interface:
        place = BusPlace(interface, _option(request.config, CHANNEL))
    else:
        place = request.getfixturevalue("canopen_hub")
    shown = request.node.stash.setdefault(SHOWN, [])
    with ExitStack() as running:

        def start(device: str = "", *, scenario: str = "", **settings: object) -> TwinProcess:
            arguments = [str(file_beside(request.path, device))] if device else []
            if scenario:
                arguments += ["--scenario", str(file_beside(request.path, scenario))]
            for name, value in settings.items():
                arguments += ["--set", f"{name}={value}"]
            twin = running.enter_context(TwinProcess(arguments, place))
            shown.append(twin.scene)
            return twin

        yield start


def _option(config: pytest.Config, name: str) -> Any:
    return config.getoption(name) or config.getini(name)


class ScenarioFile(pytest.File):
    """A file with one scenario, which is one test."""

    def collect(self) -> Iterable[pytest.Item]:
        """The test; raises `CollectError` with a line for everything that is wrong."""
        try:
            scenario = read(str(self.path))
        except UserError as mistakes:
            raise self.CollectError(str(mistakes)) from None
        name = " ".join(scenario.name.split()).replace("::", ":")  # two would split node ids
        yield ScenarioItem.from_parent(self, name=name or self.path.stem, scenario=scenario)


class ScenarioItem(pytest.Item):
    """One scenario; `-k` finds it by its name, its file, its nodes and what it covers."""

    verdict: Verdict

    def __init__(self, *, scenario: Scenario, **described: object) -> None:
        super().__init__(**described)  # type: ignore[arg-type]
        self.scenario = scenario
        self.extra_keyword_matches.update(scenario.nodes, scenario.covers)

    def setup(self) -> None:
        """Play it; raises if it could not be carried out."""
        from canopen_twins.scenario import Kind  # noqa: PLC0415

        self.verdict = canopen_twins.play(self.scenario)
        keep(self, self.verdict)
        if self.verdict.kind is not Kind.FAIL:
            judge([self.verdict])

    def runtest(self) -> None:
        """Raises if something else has come than was expected."""
        judge([self.verdict])

    def reportinfo(self) -> tuple[Path, int, str]:
        """Where it is, for the headings of reports."""
        return self.path, 0, self.name


def read(name: str) -> Scenario:
    """A scenario of a file, told by its path from here, or one that is shipped.

    Raises:
        UserError: there is neither, or something is wrong with it.
    """
    from canopen_twins.cli.scenario_file import load  # noqa: PLC0415

    here = Path.cwd()
    return load(str(Path(name).relative_to(here)) if Path(name).is_relative_to(here) else name)


def beside(test: Path, name: str) -> Scenario:
    """The scenario a test asks for; fails it if there is none, or something is wrong with it."""
    file = test.parent / name
    try:
        return read(str(file) if file.exists() else name)
    except UserError as mistakes:
        told = str(mistakes)
    pytest.fail(told, pytrace=False)


def file_beside(test: Path, device: What) -> What:
    """The path of a device's file that lies beside a test; anything else as it is."""
    if isinstance(device, type):
        return device
    file = test.parent / device
    return file if file.is_file() else device


def settle(item: pytest.Item) -> None:
    """Play the rest of the scenarios of a test, note what came of them, and judge them."""
    if TOLD not in item.stash:
        return
    for bench in item.stash[TOLD]:
        bench.finish()
    note(item)
    verdicts = [bench.verdict for bench in item.stash[TOLD]]
    del item.stash[TOLD]
    judge(verdicts)


def judge(verdicts: Iterable[Verdict]) -> None:
    """Raises what pytest takes for a failure, or else for a skipped test; nothing for PASS."""
    from canopen_twins.scenario import Kind  # noqa: PLC0415

    bad = [verdict for verdict in verdicts if verdict.kind is not Kind.PASS]
    if failed := [str(verdict) for verdict in bad if not verdict.ok]:
        pytest.fail("\n".join(failed), pytrace=False)
    for verdict in bad:
        skipped = next(each for each in verdict.outcomes if each.kind is Kind.SKIP)
        pytest.skip(f"{verdict.file}:{skipped.line}: {skipped.seen}")


def note(item: pytest.Item) -> None:
    """Keep the verdicts of a test so far as its properties, for `--junitxml` and others."""
    for bench in item.stash.get(TOLD, []):
        keep(item, bench.verdict)


def keep(item: pytest.Item, verdict: Verdict) -> None:
    """The same with one of them."""
    from canopen_twins.scenario.verdict import as_properties  # noqa: PLC0415

    item.user_properties.extend(as_properties(verdict))
