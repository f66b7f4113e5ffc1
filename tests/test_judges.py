from dataclasses import replace
from pathlib import Path

import pytest

from canopen_twins.scenario import load, play
from canopen_twins.scenario.verdict import Kind

SCENARIOS = Path(__file__).parents[1] / "scenarios"
JUDGES = sorted([*SCENARIOS.glob("*_master_*.yaml"), SCENARIOS / "topcon_partner_stops.yaml"])
MASTERS = "The master's."


@pytest.fixture(params=[path for path in JUDGES if MASTERS in path.read_text()], ids=Path.name.fget)
def judge(request):
    return load(request.param)


def test_a_judge_finds_out_a_master_that_does_nothing(judge):
    steps = tuple(step for step in judge.steps if not step.note.startswith(MASTERS))
    assert len(steps) < len(judge.steps)
    kinds = {outcome.kind for outcome in play(replace(judge, steps=steps)).outcomes}
    assert Kind.FAIL in kinds


def test_every_step_of_its_master_matters_to_a_judge(judge):
    for step in judge.steps:
        if step.note.startswith(MASTERS):
            others = tuple(other for other in judge.steps if other is not step)
            assert not play(replace(judge, steps=others)).ok, f"line {step.line} may be left out"
