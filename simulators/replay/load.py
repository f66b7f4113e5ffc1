"""Reads scenarios and bench files: all that is wrong at once, before anything is on a bus."""

from collections.abc import Mapping
from pathlib import Path

from simulators import devices
from simulators.documents.document import Item, read
from simulators.documents.problems import Problems
from simulators.replay.cast import Find, read_node
from simulators.replay.rehearsal import Rehearsal
from simulators.replay.scenario import NodeSpec, Scenario
from simulators.replay.steps import StepReader
from simulators.segment import Segment

VERSION = 1


def load(path: Path, find: Find = devices.find) -> Scenario:
    """The scenario of a file.

    Args:
        path: Of the file.
        find: The class of a device by its name; raises `UserError` if there is none.

    Raises:
        ScenarioError: with a line for everything that is wrong.
    """
    problems = Problems(str(path))
    fields = read(path, problems).fields(("version", "node", "steps"), ("name", "note"))
    if version := fields.get("version"):
        with problems.at(version):
            _check(version)
    texts = {"name": path.stem, "note": ""}
    for key, text in fields.items():
        if key in texts:
            with problems.at(text):
                texts[key] = text.text
    nodes: dict[str, NodeSpec] = {}
    if node := fields.get("node"):
        with problems.at(node):
            nodes = dict([read_node(node, find)])
    reader = _reader(nodes)
    if steps := fields.get("steps"):
        with problems.at(steps):
            for step in steps.items:
                reader.read(step)
    problems.settle()
    return Scenario(path, texts["name"], texts["note"], nodes, tuple(reader.steps))


def load_bench(path: Path, find: Find = devices.find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there.

    Args:
        path: Of the file.
        find: As for `load`.

    Raises:
        ScenarioError: with a line for everything that is wrong; two nodes may have one node id.
    """
    problems = Problems(str(path))
    fields = read(path, problems).fields(("version", "nodes"), ("note",))
    if version := fields.get("version"):
        with problems.at(version):
            _check(version)
    nodes: dict[str, NodeSpec] = {}
    if given := fields.get("nodes"):
        segment = Segment()
        with problems.at(given):
            for name, pair in given.some_pairs.items():
                with problems.at(pair.key):
                    _, nodes[name] = read_node(pair.value, find)
                    segment.node(nodes[name].create(), name)
    problems.settle()
    return nodes


def _check(version: Item) -> None:
    if version.whole != VERSION:
        raise version.wrong(f"version {version.text} is unknown; this program reads {VERSION}")


def _reader(nodes: dict[str, NodeSpec]) -> StepReader:
    for name, spec in nodes.items():
        return StepReader(name, Rehearsal(spec.create()))
    return StepReader("", None)
