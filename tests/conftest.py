from collections.abc import Callable

import pytest
from hypothesis import settings
from probe import Probe

from canopen_twins import Bench

pytest_plugins = ["pytester"]
collect_ignore = ["project_beside"]  # it runs by itself: see test_beside.py

# the same examples in every run, however slow the machine
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


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
