"""Plays the scenarios that are shipped, and keeps what was expected in them and came."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from pkgutil import iter_modules
from typing import NamedTuple

from canopen_twins import devices
from canopen_twins.scenario import load, play
from canopen_twins.scenario.actions import Expectation, Inject, Read
from canopen_twins.scenario.frame_matchers import EmcyLike
from canopen_twins.scenario.matchers import Holds
from canopen_twins.scenario.scenario import NodeSpec, Scenario, Step
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import Wanted
from canopen_twins.scenario.verdict import Kind, Verdict

FOLDER = Path(__file__).parent.parent / "scenarios"


class Injected(NamedTuple):
    """A fault, with something below it in the file that was expected and came."""

    fault: str


class Told(NamedTuple):
    """An emergency; what the file leaves open is None."""

    code: int | None
    detail: int | None


class Value(NamedTuple):
    """What an object was, looked at or read."""

    target: Target
    wanted: Wanted


Fact = Injected | Told | Value


class Proof(NamedTuple):
    """What one scenario proves."""

    file: str
    covers: Collection[str]
    """The statements it is about; none if it has not passed."""
    facts: Mapping[str, Collection[Fact]]
    """Of each device that takes part, by its name."""


def shipped() -> list[str]:
    """The devices of this project, whatever else is installed."""
    return sorted({module.name for module in iter_modules(devices.__path__)} - {devices.OF_FILES})


def proofs() -> tuple[Proof, ...]:
    """One for each file, in their order; every one is played."""
    scenarios = [load(path) for path in sorted(FOLDER.glob("*.yaml"))]
    return tuple(prove(scenario, play(scenario)) for scenario in scenarios)


def prove(scenario: Scenario, verdict: Verdict) -> Proof:
    """What a scenario proves that has come out like this; what has not come proves nothing."""
    passed = _passed(verdict)
    facts: dict[str, list[Fact]] = {_name(spec): [] for spec in scenario.nodes.values()}
    for step in (*scenario.steps, *scenario.cleanup):
        if step.node in scenario.nodes:
            facts[_name(scenario.nodes[step.node])] += _facts(step, passed)
    return Proof(scenario.file.name, scenario.covers if verdict.ok else (), facts)


def _passed(verdict: Verdict) -> Collection[int]:
    """The lines at which everything has come, whenever it was expected."""
    lines = {outcome.line for outcome in verdict.outcomes}
    return lines - {each.line for each in verdict.outcomes if each.kind is not Kind.PASS}


def _name(spec: NodeSpec) -> str:
    return next(name for name in shipped() if devices.find(name) is spec.device)


def _facts(step: Step, passed: Collection[int]) -> Iterator[Fact]:
    match step.action:
        case Inject(faults) if any(line > step.line for line in passed):
            yield from map(Injected, faults)
        case _ if step.line not in passed:
            return
        case Expectation(EmcyLike(code, _, detail), never=False):
            yield Told(code, detail)
        case Expectation(Holds(wanted), never=False) | Read(wanted):
            yield from (Value(*each) for each in wanted)
