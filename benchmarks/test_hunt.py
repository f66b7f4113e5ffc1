"""A hunt: one of its runs, and what a second worker brings."""

from functools import partial
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.run import run
from canopen_twins.hunt.search import lost
from canopen_twins.hunt.workers import workers

MASTERS = Path(__file__).parent.parent / "docs" / "examples" / "masters"
RUNS = 60
LOST = Plan(({"at": 5.0, "inject": {"frame_lost": {"times": 3}}},))


@pytest.fixture
def contract(tmp_path: Path) -> Contract:
    """That of the TopCon and its reference master, for 24 s and 6 s more to recover in."""
    text = (MASTERS / "topcon_contract.yaml").read_text("utf-8")
    file = tmp_path / "contract.yaml"
    file.write_text(text.replace("duration: 16", "duration: 24"), "utf-8")
    (tmp_path / "topcon_master.py").symlink_to(MASTERS / "topcon_master.py")
    return Contract(file)


def test_run(benchmark: BenchmarkFixture, contract: Contract):
    """From the text of its file to the outcome, with three frames that get lost."""
    result = benchmark.pedantic(run, args=(contract, LOST), rounds=15, warmup_rounds=2)
    assert (round(result.seconds), result.fired, result.failures) == (30, 1, ())


@pytest.mark.parametrize("jobs", [1, 2])
def test_workers(benchmark: BenchmarkFixture, contract: Contract, jobs: int):
    """So many runs, by workers that have begun to work."""
    with workers(jobs, lost) as play:

        def runs() -> list[object]:
            return list(play(partial(run, contract), [LOST] * RUNS))

        results = benchmark.pedantic(runs, rounds=3, warmup_rounds=1)
    assert len(results) == RUNS
