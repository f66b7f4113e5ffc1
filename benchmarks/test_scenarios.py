"""Scenario files: reading one of the library and the longest there can be, playing the library."""

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from pytest_benchmark.fixture import BenchmarkFixture

from canopen_twins.files.document import LARGEST_FILE
from canopen_twins.scenario import load, play
from canopen_twins.scenario.verdict import Kind

LIBRARY = sorted((Path(__file__).parent.parent / "scenarios").glob("topcon_*.yaml"))
HEAD = "version: 1\nnode: {device: topcon}\nsteps:\n"
STEP = "- {at: 1000.00, send: 080#}\n"


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """The largest file of the library, and one as large as a file may be: 9360 steps."""
    longest = tmp_path / "longest.yaml"
    longest.write_text(HEAD + STEP * ((LARGEST_FILE - len(HEAD)) // len(STEP)))
    return {"library": max(LIBRARY, key=lambda path: path.stat().st_size), "longest": longest}


def by_pyyaml(path: Path) -> object:
    """What reading the text alone takes."""
    return yaml.safe_load(path.read_text("utf-8"))


@pytest.mark.parametrize("size", ["library", "longest"])
@pytest.mark.parametrize("read", [load, by_pyyaml], ids=["load", "pyyaml"])
def test_file(
    benchmark: BenchmarkFixture, files: dict[str, Path], read: Callable[[Path], object], size: str
):
    benchmark.pedantic(read, args=(files[size],), rounds=5, warmup_rounds=1)


def test_play(benchmark: BenchmarkFixture):
    """Every scenario of the TopCon, one after the other."""
    scenarios = [load(path) for path in LIBRARY]
    kinds = benchmark.pedantic(lambda: {play(each).kind for each in scenarios}, rounds=3)
    assert kinds == {Kind.PASS}
