"""A whole file: a scenario, or a bench."""

from typing import Annotated

from pydantic import ConfigDict, Field

from simulators.documents.document import Item
from simulators.documents.rules import OneOf
from simulators.documents.table import IfRight, Leaf, Listed, Table
from simulators.replay.file.leaves import BY_NAME, Name, Parameters, Seconds, Text, whole
from simulators.replay.file.step import AnyStep, Step

VERSION = 1
MOST_STEPS, MOST_NODES = 10_000, 127
HIGHEST_SEED = 0xFFFF_FFFF
BIT_RATES = 10_000, 1_000_000  # CiA 301, 5.2


def _check(version: Item) -> None:
    """Another version is a problem; the rest is looked at all the same."""
    with version.problems.at(version):
        if version.whole != VERSION:
            raise version.wrong(f"version {version.text} is unknown; this program reads {VERSION}")


KNOWN_VERSION = Leaf(_check, {"const": VERSION})
NODE_ID = Leaf(lambda item: item.value, {"type": "integer", "minimum": 1, "maximum": 127})


class Node(Table):
    """A device as it is delivered."""

    device: Name
    """Which device, by its name in `canopen-twin list`."""
    node_id: Annotated[Item, NODE_ID] | None = None
    """The node id it is delivered with, 1..127."""
    settings: Parameters | None = None
    """How it is delivered and what is around it; see `canopen-twin settings DEVICE`."""


Nodes = Annotated[dict[Name, IfRight[Node]], Field(min_length=1, max_length=MOST_NODES), BY_NAME]


class File(Table):
    """What every file has."""

    version: Annotated[Item, KNOWN_VERSION]
    """Version of the format: 1."""
    note: Text | None = None
    """Free text."""


class BenchFile(File):
    """Several twins on one bus."""

    model_config = ConfigDict(title="Bench file")

    nodes: Nodes
    """Who is on the bus, by names of your own."""


class ScenarioFile(File):
    """Twins and what happens to them; it is played and judged."""

    model_config = ConfigDict(title="Scenario")
    rules = (OneOf("says who takes part", ("node", "nodes"), "a scenario"),)

    name: Text | None = None
    """What happens, in a few words."""
    covers: Listed[Text] | None = None
    """The statements it is about, such as T-193."""
    seed: Annotated[Item, whole(0, HIGHEST_SEED)] | None = None
    """Where chance begins, for every fault and device that has a `seed` and is given none."""
    duration: Seconds | None = None
    """Seconds that the run lasts at least."""
    bit_rate: Annotated[Item, whole(*BIT_RATES)] | None = None
    """Bit/s of the simulated bus; frames take no time if it is left out."""
    node: Node | None = None
    """Who takes part, if it is one; its name is that of its device."""
    nodes: Nodes | None = None
    """Who takes part, if it is more than one, by names of your own."""
    steps: Annotated[Listed[IfRight[Step]], Field(max_length=MOST_STEPS)]
    """What happens, in the order of time."""
    cleanup: Annotated[Listed[IfRight[AnyStep]], Field(max_length=MOST_STEPS)] | None = None
    """Steps that are carried out in the end, whatever came of the others."""
