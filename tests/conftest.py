import gc
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import canopen
import pytest
from hypothesis import settings
from played import Played, player
from probe import Probe

from canopen_twins import Bench

pytest_plugins = ["pytester"]
collect_ignore = ["project_beside"]  # it runs by itself: see test_beside.py

LEAN = "-p no:anyio -p no:benchmark -p no:hypothesispytest"
"""Of the pytest runs that tests start: a second of imports each, which none of them is about."""
WITH_RUNS = ("tests/test_every_scenario.py", "tests/test_coverage.py")  # the fixture `played`
IN_REAL_TIME = (
    "tests/charger/test_served.py",
    "tests/compare/test_local_node.py",
    "tests/conform/test_live.py",
    "tests/control/test_events.py",
    "tests/control/test_guard.py",
    "tests/control/test_how_to.py",
    "tests/control/test_panel.py",
    "tests/hub/test_server.py",
    "tests/hunt/test_workers.py",
    "tests/test_how_to_judge.py",
    "tests/test_master_beside.py",
    "tests/test_serve.py",
    "tests/test_three_ways.py",
)
"""They wait for more than half of their time."""
TOGETHER = dict.fromkeys(WITH_RUNS, "shipped scenarios") | dict.fromkeys(IN_REAL_TIME, "real time")

# what one process of a run has compiled, no other has to: there are two hundred of them
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# the same examples in every run, however slow the machine
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


def pytest_configure() -> None:
    """What tests start hears these signals, even where the shell around us ignores them."""
    for number, handler in (
        (signal.SIGINT, signal.default_int_handler),
        (signal.SIGHUP, signal.SIG_DFL),
    ):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, handler)


def pytest_collection_finish() -> None:
    """What there is by now stays to the end: to look for garbage in it takes a tenth of a run."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers():
    """One more than pytest-xdist would take: tests in real time wait for most of it."""
    return (yield) + 1


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """A file goes to one worker, which makes the fixtures of the file once; large ones go first.

    Some files go together: those that look at the runs of shipped scenarios, and those that wait.
    The groups of pytest-xdist 3.8 are of no effect with pytest 9.2.
    """
    from xdist.scheduler import LoadScopeScheduling  # noqa: PLC0415

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition("::")[0]
            return TOGETHER.get(file, file)

    return Scheduling(config, log)


@pytest.fixture(scope="session", autouse=True)
def nobody_else_runs(tmp_path_factory) -> Iterator[None]:
    """Twins that run on this machine are no business of a test, nor those of tests anybody's.

    Nor are options that somebody gives to pytest those of the runs that tests start.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("running")))
        patch.setenv("PYTEST_ADDOPTS", LEAN)
        yield


@pytest.fixture
def pytester(pytester, monkeypatch) -> pytest.Pytester:
    """That of pytest, which forgets what the environment says of options."""
    monkeypatch.setenv("PYTEST_ADDOPTS", LEAN)
    return pytester


@pytest.fixture
def bench_of() -> Callable[..., Bench]:
    """A bench with a probe as node 5; keywords are those of its profile."""

    def bench_of(**profile):
        return Bench.of({"probe": Probe(**profile)})

    return bench_of


@pytest.fixture
def bench(bench_of) -> Bench:
    """A bench with a probe as node 5, in Pre-operational."""
    return bench_of()


@pytest.fixture
def operational(bench) -> Bench:
    """The same, in Operational."""
    bench.send("000#0105")
    return bench


@pytest.fixture(scope="session")
def played(tmp_path_factory) -> Callable[[Path], Played]:
    """The run of a shipped scenario; who asks for it stands in WITH_RUNS."""
    return player(tmp_path_factory.mktemp("played"))


@pytest.fixture
def quick_to_disconnect(monkeypatch) -> None:
    """A canopen network in real time that is gone at once: it waits for a cycle of its notifier.

    For the tests that ask for it only: in simulated time an hour has 360,000 of these cycles.
    """
    monkeypatch.setattr(canopen.Network, "NOTIFIER_CYCLE", 0.01)
