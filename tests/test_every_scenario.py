from io import StringIO
from pathlib import Path

import pytest

from canopen_twins.scenario import load, play
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.matchers import EmcyLike

SCENARIOS = sorted(Path(__file__).parents[1].glob("scenarios/*.yaml"))


@pytest.fixture(params=SCENARIOS, ids=lambda path: path.stem)
def scenario(request):
    return load(request.param)


def test_it_is_a_story_that_comes_out_as_told_and_the_same_each_time(scenario):
    traces = [StringIO(), StringIO()]
    verdicts = [play(scenario, trace) for trace in traces]
    assert verdicts[0].ok, str(verdicts[0])
    assert verdicts[0] == verdicts[1]
    assert traces[0].getvalue() == traces[1].getvalue()


def test_it_says_what_it_is_about_and_expects_something(scenario):
    assert scenario.name != scenario.file.stem
    assert scenario.note
    assert play(scenario).outcomes


def test_an_emergency_is_expected_with_all_that_it_says(scenario):
    wanted = [
        (step.line, step.action.matcher)
        for step in (*scenario.steps, *scenario.cleanup)
        if isinstance(step.action, Expectation) and not step.action.never
    ]
    signs = [(line, sign) for line, sign in wanted if isinstance(sign, EmcyLike)]
    assert [line for line, sign in signs if None in (sign.code, sign.register, sign.detail)] == []


def test_its_name_begins_with_that_of_a_device(scenario):
    assert scenario.file.stem.split("_")[0] in scenario.nodes
