from textwrap import dedent

import pytest
from probe import Probe

from canopen_twins.scenario import ScenarioError, load_bench

from .conftest import find


@pytest.fixture
def loaded(tmp_path):
    """The nodes of the text of a bench file."""

    def loaded(text):
        path = tmp_path / "bench.yaml"
        path.write_text(dedent(text), encoding="utf-8")
        return load_bench(path, find)

    return loaded


def test_nodes_are_told_as_in_a_scenario_each_with_its_name(loaded):
    nodes = loaded(
        """\
        version: 1
        note: Two supplies.
        nodes:
          left: {device: topcon, node_id: 5, settings: {load: resistor 4}}
          right: {device: topcon, node_id: 0x06}
          other: {device: probe, node_id: 7}
        """
    )
    devices = {name: spec.create() for name, spec in nodes.items()}
    assert {name: device.node_id for name, device in devices.items()} == {
        "left": 5,
        "right": 6,
        "other": 7,
    }
    assert devices["left"].settings.load == "resistor 4"
    assert type(devices["other"]) is Probe


WRONG = {
    "version: 2\nnodes: {a: {device: probe}}": ["1:10: version 2 is unknown; this program reads 1"],
    "nodes: {}": [
        "1:1: 'version' is missing",
        "1:8: empty; at least one key with a value is wanted here",
    ],
    "version: 1\nnode: {device: probe}": [
        "1:1: 'nodes' is missing",
        "2:1: unknown key 'node': did you mean 'nodes'?",
    ],
    """\
    version: 1
    nodes:
      a: {device: probe, node_id: 5}
      b: {device: probe}
      c: {device: tobcon, node_id: 6}
      d: {device: topcon, node_id: 128}
      e: {device: topcon, node_id: 9, settings: {laod: open}}
      a: {device: probe, node_id: 11}
    """: [
        "4:3: two nodes with node id 5 on one bus",
        "5:15: unknown device 'tobcon': did you mean 'topcon'?",
        "6:32: node id 128 is not in 1..127",
        "7:46: unknown setting 'laod': did you mean 'load'?",
        "8:3: 'a' stands here twice, first in line 3; leave one of them out",
    ],
}


@pytest.mark.parametrize("text", WRONG)
def test_everything_that_is_wrong_is_told_with_its_place(loaded, tmp_path, text):
    with pytest.raises(ScenarioError) as refusal:
        loaded(text)
    assert refusal.value.lines == tuple(f"{tmp_path}/bench.yaml:{line}" for line in WRONG[text])
