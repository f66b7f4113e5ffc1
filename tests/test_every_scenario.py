import json
from contextlib import redirect_stdout
from io import StringIO

import pytest
from played import SCENARIOS

from canopen_twins.cli import main
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.frame_matchers import EmcyLike


@pytest.fixture(params=SCENARIOS, ids=lambda path: path.stem)
def run(request, played):
    return played(request.param)


def test_it_is_a_story_that_comes_out_as_told(run):
    assert run.verdict.ok, str(run.verdict)


def test_a_replay_of_its_record_is_the_same_run_frame_by_frame_and_outcome_by_outcome(run, capsys):
    assert all(view.nmt.points for view in run.observer.nodes)  # nobody looks at the replay so
    assert (run.record / "trace.log").read_text("utf-8") == run.trace
    events = map(json.loads, (run.record / "events.jsonl").read_text("utf-8").splitlines())
    told = [(each["line"], each["verdict"]) for each in events if each["kind"] == "outcome"]
    assert sorted(told) == sorted((each.line, each.kind) for each in run.verdict.outcomes)
    assert main(["replay", str(run.record)]) == 0
    assert capsys.readouterr().out == run.trace


@pytest.fixture(scope="module")
def listed():
    """What `canopen-twin list` prints."""
    with redirect_stdout(StringIO()) as out:
        assert main(["list"]) == 0
    return out.getvalue().splitlines()


def test_it_says_what_it_is_about_and_of_which_device_and_expects_something(run, listed):
    file, name = run.scenario.file, run.scenario.name
    (line,) = (line for line in listed if line.startswith(f"{file.name} "))
    assert line.split(maxsplit=1)[1] == name != file.stem
    assert file.stem.split("_")[0] in run.scenario.nodes
    assert run.scenario.note
    assert run.verdict.outcomes


def test_an_emergency_is_expected_with_all_that_it_says(run):
    wanted = [
        (step.line, step.action.matcher)
        for step in (*run.scenario.steps, *run.scenario.cleanup)
        if isinstance(step.action, Expectation) and not step.action.never
    ]
    signs = [(line, sign) for line, sign in wanted if isinstance(sign, EmcyLike)]
    assert [line for line, sign in signs if None in (sign.code, sign.register, sign.detail)] == []
