"""Reads scenarios and bench files: all that is wrong at once, before anything is on a bus."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from canopen_twins.files.document import Item
from canopen_twins.files.table import understand_table
from canopen_twins.scenario.load import Find
from canopen_twins.scenario.reading.length import check_length
from canopen_twins.scenario.reading.participants import Participants
from canopen_twins.scenario.reading.steps import StepReader
from canopen_twins.scenario.scenario import NodeSpec, Scenario, Step
from canopen_twins.scenario.schema import AnyStep, BenchFile, Node, ScenarioFile

DEFAULT_SEED = 1


def read_scenario(path: Path, find: Find) -> Scenario:
    """The scenario of a file.

    Raises:
        DocumentError: with a line for everything that is wrong.
    """
    return understand_table(path, ScenarioFile, lambda told: _scenario(told, path, find))


def read_bench(path: Path, find: Find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there; raises as `read_scenario` does."""
    return understand_table(
        path, BenchFile, lambda told: _participants(told.nodes, Participants(find)).specs
    )


def _scenario(told: ScenarioFile, path: Path, find: Find) -> Scenario:
    seed = None if told.seed is None else told.seed.whole
    duration = None if told.duration is None else told.duration.seconds
    participants = Participants(find, seed)
    if told.node is not None:
        participants.take(told.node.device, told.node, told.node.place)
    _participants(told.nodes or {}, participants)
    return Scenario(
        path,
        name=_text(told.name) or path.stem,
        note=_text(told.note),
        nodes=participants.specs,
        steps=_steps(told.steps, participants, duration),
        cleanup=_steps(told.cleanup or [], participants, 0.0),
        covers=tuple(each.text for each in told.covers or []),
        seed=DEFAULT_SEED if seed is None else seed,
        duration=duration,
        bit_rate=None if told.bit_rate is None else told.bit_rate.whole,
        bit_rate_line=0 if told.bit_rate is None else told.bit_rate.line,
    )


def _participants(nodes: Mapping[Item, Node | None], participants: Participants) -> Participants:
    for name, node in nodes.items():
        participants.take(name, node, name)
    return participants


def _steps(
    told: Sequence[AnyStep | None], participants: Participants, duration: float | None
) -> tuple[Step, ...]:
    reader = StepReader(participants)
    steps = [step for step in told if step is not None]
    for step in steps:
        reader.read(step)
    if steps and steps[0].place.problems.none:
        check_length(steps, reader.steps, duration)
    return tuple(reader.steps)


def _text(told: Item | None) -> str:
    return "" if told is None else told.text
