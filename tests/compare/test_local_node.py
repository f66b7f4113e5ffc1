"""What canopen's LocalNode does otherwise than a slave is found, as far as a master comes upon it.

`canopen-twin` has its reasons not to be one: see docs/explanation/how-it-works.md.
"""

import pytest

from canopen_twins import devices
from canopen_twins.record.compare import Comparison

from .conftest import compared, told, traced
from .local_node import BLOCK, asked, local_node, machine

RAMP = "SDO 0x2000:00 Ramp"
NAME = "SDO 0x1008:00 Manufacturer device name"
REFUSED, CODE, VALUE = "refused by one, not by the other", "another abort code", "another value"
FORM, LACKS, MORE = "another form", "only the twin sends it", "only the device sends it"
DEVIATIONS = [
    ("a length that is left open is refused", "605#2200200064000000", f"{RAMP}: {REFUSED}"),
    ("it is another value then", "605#4000200000000000", f"{RAMP}: {VALUE}"),
    ("limits are not watched", "605#2B002000D0070000", f"{RAMP}: {REFUSED}"),
    ("one code for every wrong length", "605#23002000D0070000", f"{RAMP}: {CODE}"),
    ("a variable has sub-indices", "605#4000100700000000", f"SDO 0x1000:07: {REFUSED}"),
    ("an array has any sub-index", "605#4003100900000000", f"SDO 0x1003:09: {CODE}"),
    ("what has no value is none", "605#4001200000000000", f"Without a value: {REFUSED}"),
    ("a segment without a transfer", "605#6000000000000000", f"SDO: {CODE}"),
    ("a block download is no write", "605#C208100000000000", f"{NAME}: {CODE}"),
    ("a block upload is a plain one", "605#A408100005000000", f"{NAME}: {FORM}"),
    (
        "the history is not erased by 0 alone",
        "605#2F03100005000000",
        f"Number of errors: {REFUSED}",
    ),
    ("anything is the signature", "605#2310100101020304", f"Save all: {REFUSED}"),
    ("a request may be short", "605#4000", f"SDO: {MORE}"),
    ("node guarding is not answered", "705#R", f"node guarding: {LACKS}"),
    ("the first heartbeats are boot-ups", "605#2B17100064000000", f"boot-up: {MORE}"),
    ("an identifier changes while in use", "605#2300180186010000", f"used by TPDO 1: {REFUSED}"),
    ("there is any transmission type", "605#2F001802F1000000", f"type TPDO 1: {REFUSED}"),
    ("event-driven PDOs are not sent", "000#0105", f"TPDO2: {LACKS}"),
    ("an RPDO is not taken", "205#01", ""),
    ("so its object is another value", "605#4000620100000000", f"Outputs 1 to 8: {VALUE}"),
    ("a PDO is not sent on request", "285#R", f"TPDO2: {LACKS}"),
    ("there is no LSS", "7E5#0401000000000000", ""),
    ("so it is not answered", "7E5#5E00000000000000", f"LSS: {LACKS}"),
    ("a stopped node is not to be stopped", "000#0205", ""),
    ("for it answers SDO", "605#4000100000000000", f"SDO 0x1000:00 Device type: {MORE}"),
    ("its heartbeats would look like one", "605#2B17100000000000", ""),
    ("a reset ends in no boot-up", "000#8105", f"boot-up: {LACKS}"),
    ("and changes no value", "605#4000200000000000", f"{RAMP}: {VALUE}"),
]


def beside(trace, eds):
    """The differences between a LocalNode and the twin of its file."""
    comparison = Comparison({"twin": devices.create(str(eds), node_id=5)})
    for tick, frame in trace:
        comparison.hear(tick, frame)
    return told(comparison.end())


def differences(bus, folder):
    eds = machine(folder / "machine.eds")
    with local_node(eds, bus):
        trace = asked(bus, [frame for _, frame, _ in DEVIATIONS])
    return beside(trace, eds)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("local_node")
    return differences({"interface": "virtual", "channel": str(folder)}, folder)


WITH_A_DIFFERENCE = [(why, words) for why, _, words in DEVIATIONS if words]


@pytest.mark.parametrize(("why", "words"), WITH_A_DIFFERENCE)
def test_a_deviation_of_a_local_node_is_found(found, why, words):
    assert any(words in line for line in found), found


def test_a_second_sdo_server_and_a_pdo_of_another_identifier_are_compared(tmp_path):
    second = """
[1201]
ParameterName=Second server
ObjectType=0x9
SubNumber=3
[1201sub0]
ParameterName=Largest sub-index
DataType=0x0005
AccessType=const
DefaultValue=2
[1201sub1]
ParameterName=Requests
DataType=0x0007
AccessType=rw
DefaultValue=0x611
[1201sub2]
ParameterName=Answers
DataType=0x0007
AccessType=rw
DefaultValue=0x591
"""
    text = BLOCK.read_text("utf-8").replace("DefaultValue=$NODEID+0x280", "DefaultValue=0x3A1")
    ours, theirs = tmp_path / "ours.eds", tmp_path / "theirs.eds"
    ours.write_text(text + second)
    theirs.write_text(text.replace("DefaultValue=0x00000002", "DefaultValue=0xBAD") + second)

    def ask(bench):
        bench.send("611#4018100200000000")
        bench.send("000#0105")
        bench.run(0.1)
        bench.set(**{"0x6401:01": 200})

    agreement = compared(traced(ask, str(theirs)), str(ours))
    assert told(agreement) == ["SDO 0x1018:02 Identity object.Product code: another value"]
    assert {"SDO", "TPDO2"} <= agreement.services("twin")
