from collections.abc import Callable
from io import StringIO
from textwrap import dedent

import pytest
from probe import Probe

from canopen_twins import devices
from canopen_twins.scenario import Scenario, ScenarioError, load, play

HEAD = "version: 1\nnode: {device: probe, node_id: 5}\nsteps:\n"


def find(name):
    return Probe if name == "probe" else devices.find(name)


@pytest.fixture
def loaded(tmp_path) -> Callable[[str], Scenario]:
    """The scenario of a text."""

    def loaded(text):
        path = tmp_path / "story.yaml"
        path.write_text(dedent(text), encoding="utf-8")
        return load(path, find)

    return loaded


@pytest.fixture
def story(loaded) -> Callable[[str], Scenario]:
    """The scenario of some steps of a probe as node 5; they begin in line 4 of the file."""
    return lambda steps: loaded(HEAD + dedent(steps))


@pytest.fixture
def problems(loaded, tmp_path) -> Callable[[str], list[str]]:
    """Everything that is wrong with a text, without the name of the file."""

    def problems(text):
        with pytest.raises(ScenarioError) as refusal:
            loaded(text)
        return [line.removeprefix(f"{tmp_path / 'story.yaml'}:") for line in refusal.value.lines]

    return problems


@pytest.fixture
def played(story) -> Callable[[str], tuple[list[str], list[str]]]:
    """What was on the bus, as "time frame", and the outcomes, as "KIND time seen"."""

    def played(steps):
        trace = StringIO()
        verdict = play(story(steps), trace)
        frames = [line.split() for line in trace.getvalue().splitlines()]
        return [f"{float(time[1:-1]):g} {frame}" for time, _, frame in frames], told(verdict)

    return played


@pytest.fixture
def judged() -> Callable[[Scenario], list[str]]:
    """The outcomes of a scenario, as "KIND time seen"."""
    return lambda scenario: told(play(scenario))


def told(verdict):
    return [f"{each.kind} {each.time:g} {each.seen}" for each in verdict.outcomes]
