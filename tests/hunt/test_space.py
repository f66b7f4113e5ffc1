"""What goes wrong with a contract, and when: the space of a hunt, read from the contract."""

import shutil
from itertools import islice
from pathlib import Path

import pytest
import yaml

from canopen_twins.cli import main
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.events import Events
from canopen_twins.hunt.run import run
from canopen_twins.hunt.space import Space

from .masters import BRITTLE

TWO = """\
version: 1
name: Two supplies
nodes:
  left: {device: topcon, node_id: 5}
  right: {device: topcon, node_id: 6}
duration: 2
recovers: {within: 2, when: {node: left, state: operational}}
steps:
  - {at: 0, node: left, expect: {never: {emcy: {code: 0x9999}}}}
always:
  - {whenever: {nmt: start, node: left}, node: left, expect: {state: operational, within: 1}}
"""


def text_of(tmp_path, plan):
    (tmp_path / "two.yaml").write_text(TWO)
    return yaml.safe_load(Contract(tmp_path / "two.yaml").text(plan))


def test_parts_of_a_contract_are_left_out_one_by_one(tmp_path):
    whole = text_of(tmp_path, Plan())
    assert Contract(tmp_path / "two.yaml").parts == 3
    assert text_of(tmp_path, Plan(left_out=(0,))) == {**whole, "steps": []}
    assert text_of(tmp_path, Plan(left_out=(1, 2))) == {
        key: value for key, value in whole.items() if key not in ("always", "recovers")
    }


def test_nodes_are_tried_in_every_order(tmp_path):
    told = text_of(tmp_path, Plan(order=("right", "left")))
    assert [*told["nodes"]] == ["right", "left"]
    contract = Contract(tmp_path / "two.yaml")
    scenario = contract.scenario(Plan())
    orders = [
        run(contract, Plan(order=order)).trace for order in ((), *Space(scenario, Events()).orders)
    ]
    assert len({*orders}) == 2


def test_everything_goes_wrong_first_when_all_is_well(tmp_path):
    scenario = Contract(tmp_path / "two.yaml")
    (tmp_path / "two.yaml").write_text(TWO)
    events = Events(moments={"left": {"{}": [0.0]}, "right": {}}, conditions={"{}": {}})
    space = Space(scenario.scenario(Plan()), events)
    firsts = [next(source).disturbances for source in space.singles()]
    by_itself = [one[0] for one in firsts if one and "frame" not in str(one[0].get("inject"))]
    assert {each.get("at") for each in by_itself if each["node"] == "left"} == {1.0}


def test_what_strikes_once_lasts_the_second_time(tmp_path):
    (tmp_path / "two.yaml").write_text(TWO)
    events = Events(moments={"left": {"{}": [0.0]}, "right": {}}, conditions={"{}": {}})
    space = Space(Contract(tmp_path / "two.yaml").scenario(Plan()), events)
    (source,) = [
        [plan.disturbances[0] for plan in islice(source, 50)]
        for source, option in zip(space.singles(), space.options, strict=False)
        if (option.node, option.fault) == ("left", "pdo_missing")
    ]
    moment = {"at": 1.0, "node": "left"}
    assert source[:2] == [
        {**moment, "inject": {"pdo_missing": {"times": 1}}},
        {**moment, "inject": "pdo_missing"},
    ]
    assert len({*map(repr, source)}) == len(source)


def test_other_values_of_a_fault_of_the_device_do_not_wait_for_its_default(tmp_path):
    (tmp_path / "two.yaml").write_text(TWO)
    events = Events(moments={"left": {}, "right": {}})
    space = Space(Contract(tmp_path / "two.yaml").scenario(Plan()), events)
    firsts = [next(source, Plan()).disturbances for source in space.singles()]
    mains = {"at": 1.0, "node": "left", "inject": {"mains": {"volts": 300.0}}}
    assert ({**mains, "inject": "mains"},) in firsts
    assert (mains,) in firsts


IO_BLOCK = Path(__file__).parents[2] / "docs" / "examples" / "io-block" / "io_block.eds"
EDS_CONTRACT = """\
version: 1
name: An I/O block is watched
node: {device: io_block.eds, node_id: 5}
space: {faults: [sdo_silence], most: 1}
duration: 3
recovers: {within: 3, when: {value: {Producer heartbeat time: 500}}}
"""


SIGN = """\
import time


def main(network):
    block = network.add_node(5)
    while True:
        time.sleep(0.5)
        temperature = int.from_bytes(block.sdo.upload(0x6401, 1), "little")
        block.sdo.download(0x6200, 1, bytes([temperature > 1000]))
"""
COOLS = """\
version: 1
name: Output 1 cools
node: {device: io_block.eds, node_id: 5}
duration: 3
always:
  - whenever: {write: {Write output 8-bit.Outputs 1 to 8: 1}}
    expect: {value: {Read analogue input 16-bit.Temperature: {min: 0}}, within: 0}
"""


@pytest.fixture
def io_block(tmp_path):
    """The EDS of a device lies beside the contract."""
    shutil.copy(IO_BLOCK, tmp_path)


def changes(tmp_path, text):
    (tmp_path / "contract.yaml").write_text(text)
    space = Space(Contract(tmp_path / "contract.yaml").scenario(Plan()), Events())
    return {(name, value) for _, name, value in space.changes}


def test_what_is_measured_goes_to_its_ends(io_block, tmp_path):
    assert changes(tmp_path, COOLS) == {
        (f"Read analogue input 16-bit.{name}", value)
        for name in ("Temperature", "Pressure")
        for value in (-32768, 32767)
    }


def test_what_the_contract_sets_is_left_to_it(io_block, tmp_path):
    steps = "steps: [{at: 1, set: {0x6401:01: 5}}]\n"
    assert {name for name, _ in changes(tmp_path, COOLS + steps)} == {
        "Read analogue input 16-bit.Pressure"
    }


def test_objects_may_be_what_goes_wrong_and_nothing_else(hunted, io_block, tmp_path):
    space = "space: {faults: [], settings: {0x6401:01: [-5]}}\n"
    _, said = hunted(SIGN, "--runs", "2", contract=COOLS + space)
    assert "set 0x6401:01: 1 step beyond the contract" in said


def test_a_device_of_a_file_is_found_out_from_another_folder(hunted, io_block, tmp_path):
    (tmp_path / "finds").mkdir()
    master = BRITTLE.replace("0x2010: 2000, 0x2014: 1", "0x1017: 500")
    code, said = hunted(master, "--runs", "2", "--finds", "finds", contract=EDS_CONTRACT)
    assert (code, "thrown away" in said) == (1, False), said
    assert main(["play", "finds/hunt-1.twin.yaml"]) == 1
