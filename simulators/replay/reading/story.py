"""Reads scenarios and bench files: all that is wrong at once, before anything is on a bus."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from simulators.documents.document import Item
from simulators.documents.table import understand_table
from simulators.replay.file.step import Deed
from simulators.replay.file.story import Bench, Node, Story
from simulators.replay.load import Find
from simulators.replay.reading.cast import Cast
from simulators.replay.reading.steps import StepReader
from simulators.replay.scenario import NodeSpec, Scenario, Step

DEFAULT_SEED = 1


def read_scenario(path: Path, find: Find) -> Scenario:
    """The scenario of a file.

    Raises:
        DocumentError: with a line for everything that is wrong.
    """
    return understand_table(path, Story, lambda told: _scenario(told, path, find))


def read_bench(path: Path, find: Find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there; raises as `read_scenario` does."""
    return understand_table(path, Bench, lambda told: _cast(told.nodes, Cast(find)).specs)


def _scenario(told: Story, path: Path, find: Find) -> Scenario:
    seed = None if told.seed is None else told.seed.whole
    cast = Cast(find, seed)
    if told.node is not None:
        cast.take(told.node.device, told.node, told.node.place)
    _cast(told.nodes or {}, cast)
    return Scenario(
        path,
        name=_text(told.name) or path.stem,
        note=_text(told.note),
        nodes=cast.specs,
        steps=_steps(told.steps, cast),
        cleanup=_steps(told.cleanup or [], cast),
        covers=tuple(each.text for each in told.covers or []),
        seed=DEFAULT_SEED if seed is None else seed,
        duration=0.0 if told.duration is None else told.duration.seconds,
        bit_rate=None if told.bit_rate is None else told.bit_rate.whole,
    )


def _cast(nodes: Mapping[Item, Node | None], cast: Cast) -> Cast:
    for name, node in nodes.items():
        cast.take(name, node, name)
    return cast


def _steps(told: Sequence[Deed | None], cast: Cast) -> tuple[Step, ...]:
    reader = StepReader(cast)
    for step in told:
        if step is not None:
            reader.read(step)
    return tuple(reader.steps)


def _text(told: Item | None) -> str:
    return "" if told is None else told.text
