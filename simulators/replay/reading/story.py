"""Reads scenarios and bench files: all that is wrong at once, before anything is on a bus."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from simulators.documents.document import Item
from simulators.documents.table import understand
from simulators.replay.file.step import Deed
from simulators.replay.file.story import Bench, Node, Story
from simulators.replay.load import Find
from simulators.replay.reading.cast import Cast
from simulators.replay.reading.length import check_length
from simulators.replay.reading.steps import StepReader
from simulators.replay.scenario import NodeSpec, Scenario, Step

DEFAULT_SEED = 1


def read_scenario(path: Path, find: Find) -> Scenario:
    """The scenario of a file.

    Raises:
        DocumentError: with a line for everything that is wrong.
    """
    return understand(path, Story, lambda told: _scenario(told, path, find))


def read_bench(path: Path, find: Find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there; raises as `read_scenario` does."""
    return understand(path, Bench, lambda told: _cast(told.nodes, Cast(find)).specs)


def _scenario(told: Story, path: Path, find: Find) -> Scenario:
    seed = None if told.seed is None else told.seed.whole
    duration = None if told.duration is None else told.duration.seconds
    cast = Cast(find, seed)
    if told.node is not None:
        cast.take(told.node.device, told.node, told.node.place)
    _cast(told.nodes or {}, cast)
    return Scenario(
        path,
        name=_text(told.name) or path.stem,
        note=_text(told.note),
        nodes=cast.specs,
        steps=_steps(told.steps, cast, duration),
        cleanup=_steps(told.cleanup or [], cast, 0.0),
        covers=tuple(each.text for each in told.covers or []),
        seed=DEFAULT_SEED if seed is None else seed,
        duration=duration,
        bit_rate=None if told.bit_rate is None else told.bit_rate.whole,
        bit_rate_line=0 if told.bit_rate is None else told.bit_rate.line,
    )


def _cast(nodes: Mapping[Item, Node | None], cast: Cast) -> Cast:
    for name, node in nodes.items():
        cast.take(name, node, name)
    return cast


def _steps(told: Sequence[Deed | None], cast: Cast, duration: float | None) -> tuple[Step, ...]:
    reader = StepReader(cast)
    deeds = [step for step in told if step is not None]
    for deed in deeds:
        reader.read(deed)
    if deeds and deeds[0].place.problems.none:
        check_length(deeds, reader.steps, duration)
    return tuple(reader.steps)


def _text(told: Item | None) -> str:
    return "" if told is None else told.text
