from itertools import permutations

import pytest
from canopen import SdoAbortedError, SdoCommunicationError

from .conftest import READ_VERSION, READ_VOLTAGE

VOLTAGE, ANSWER = "Voltage reference", "585#4B20200000000000"
SEGMENTS = ["605#6000000000000000", "605#7000000000000000"]
SIZE, *PARTS = "585#410A100008000000", "585#0056342E31312E34", "585#1D35000000000000"


def read_version(bench):
    """A segmented transfer, whatever is answered."""
    return [bench.send(text) for text in (READ_VERSION, *SEGMENTS)]


def test_an_access_is_refused_with_a_code_and_not_carried_out(topcon):
    topcon.inject("sdo_abort", object=VOLTAGE, code=0x08000022)
    with pytest.raises(SdoAbortedError) as abort:
        topcon.sdo[VOLTAGE].raw = 2000
    assert abort.value.code == 0x08000022
    topcon.clear("sdo_abort")
    assert topcon.sdo[VOLTAGE].raw == 0


@pytest.mark.parametrize("target", [0x2010, "0x2010", "0x2010:00", VOLTAGE])
def test_an_object_is_named_as_its_users_do(topcon, target):
    topcon.inject("sdo_abort", object=target)
    assert topcon.send("605#4010200000000000") == ["585#8010200000000008"]
    assert topcon.send(READ_VOLTAGE) == [ANSWER]


@pytest.mark.parametrize("target", ["Identity Object.Serial number", "0x1018:04"])
def test_an_entry_of_a_record_is_named_by_both_names_or_its_address(topcon, target):
    topcon.inject("sdo_silence", object=target)
    assert len(topcon.send("605#4018100300000000")) == 1
    assert topcon.send("605#4018100400000000") == []


def test_only_reading_or_only_writing_may_be_struck(topcon):
    topcon.inject("sdo_abort", access="write")
    assert topcon.sdo[VOLTAGE].raw == 0
    with pytest.raises(SdoAbortedError):
        topcon.sdo[VOLTAGE].raw = 1
    topcon.inject("sdo_abort", access="read")
    topcon.sdo[VOLTAGE].raw = 1
    with pytest.raises(SdoAbortedError):
        _ = topcon.sdo[VOLTAGE].raw


def test_the_nth_access_is_struck_and_then_it_heals(topcon, active):
    topcon.inject("sdo_silence", object=0x2020, nth=2, times=2)
    answers = []
    for expected in (["sdo_silence"], ["sdo_silence"], [], []):
        answers.append(topcon.send(READ_VOLTAGE))
        assert active() == expected
    assert answers == [[ANSWER], [], [], [ANSWER]]


def test_a_write_whose_answer_is_lost_is_carried_out(topcon):
    topcon.inject("sdo_silence", times=1)
    with pytest.raises(SdoCommunicationError, match="No SDO response"):
        topcon.sdo[VOLTAGE].raw = 2000
    assert topcon.sdo[VOLTAGE].raw == 2000


def test_an_answer_comes_late_also_after_another_request(topcon, active):
    topcon.inject("sdo_late", seconds=0.03, times=1)
    assert topcon.send("605#4017100000000000") == []
    assert topcon.send(READ_VOLTAGE) == [ANSWER]
    assert topcon.run(0.029) == []
    assert active() == ["sdo_late"]
    assert topcon.run(0.001) == ["585#4B17100064000000"]
    assert active() == []


def test_a_late_answer_is_lost_when_the_fault_is_cleared(topcon):
    topcon.inject("sdo_late", seconds=0.03)
    topcon.send(READ_VOLTAGE)
    topcon.clear()
    assert topcon.run(0.09) == []


def test_the_answer_to_an_initiate_names_another_index(topcon):
    topcon.inject("sdo_wrong_index")
    assert topcon.send(READ_VOLTAGE) == ["585#4B21200000000000"]
    with pytest.raises(SdoCommunicationError, match=r"0x2021.*instead"):
        _ = topcon.sdo["Actual voltage"].raw
    assert read_version(topcon)[1:] == [[part] for part in PARTS]


def test_a_toggle_bit_does_not_alternate(topcon):
    topcon.inject("sdo_wrong_toggle", segment=2)
    assert read_version(topcon) == [[SIZE], [PARTS[0]], ["585#0D35000000000000"]]
    with pytest.raises(SdoCommunicationError, match="Toggle bit mismatch"):
        topcon.sdo.upload(0x100A, 0)
    assert str(topcon.trace[-1].frame) == "605#8000000000000305"


@pytest.mark.parametrize(("by", "command"), [(-1, 0x4F), (1, 0x47), (2, 0x43), (4, 0x4B)])
def test_an_expedited_answer_has_another_size(topcon, by, command):
    topcon.inject("sdo_wrong_size", by=by)
    assert topcon.send(READ_VOLTAGE) == [f"585#{command:02X}20200000000000"]


def test_a_segmented_answer_announces_another_size(topcon):
    topcon.inject("sdo_wrong_size", by=3)
    assert read_version(topcon)[0] == ["585#410A10000B000000"]
    assert topcon.send("605#2F10200000000000") != []  # the answer to a write has no size


def test_a_transfer_stands_still_from_a_segment_on_and_the_next_goes_through(topcon):
    topcon.inject("sdo_stall", object=0x100A, segment=1, times=1)
    assert read_version(topcon) == [[SIZE], [], []]
    assert read_version(topcon) == [[SIZE], [PARTS[0]], [PARTS[1]]]


def test_a_segment_is_refused(topcon):
    topcon.inject("sdo_abort", segment=2, code=0x08000000, times=1)
    assert read_version(topcon) == [[SIZE], [PARTS[0]], ["585#800A100000000008"]]
    assert topcon.send(SEGMENTS[0]) == ["585#8000000001000405"]  # nothing is open any more
    assert topcon.run(0.05) == []


def test_a_stopped_node_answers(topcon):
    topcon.send("000#0205")
    assert topcon.send(READ_VOLTAGE) == []
    topcon.inject("sdo_in_wrong_state")
    assert topcon.send(READ_VOLTAGE) == [ANSWER]
    assert read_version(topcon) == [[SIZE], [PARTS[0]], [PARTS[1]]]
    assert topcon.twin.node.state == "STOPPED"
    topcon.clear()
    assert topcon.send(READ_VOLTAGE) == []


def test_a_transfer_of_a_stopped_node_ends_when_the_fault_is_cleared(topcon):
    topcon.inject("sdo_in_wrong_state")
    topcon.send("000#0205")
    topcon.send(READ_VERSION)
    topcon.clear()
    sent = topcon.run(60.0)
    assert set(sent) == {"705#04"}


def test_a_stopped_node_refuses_nothing_it_does_not_hear(topcon):
    topcon.send("000#0205")
    topcon.inject("sdo_abort")
    assert topcon.send(READ_VOLTAGE) == []


@pytest.mark.parametrize("order", [*permutations(("sdo_abort", "sdo_late", "sdo_wrong_index"))])
def test_sdo_faults_compose_in_any_order(topcon, order):
    for name in order:
        topcon.inject(name, object=0x2020)
    assert topcon.send(READ_VOLTAGE) == []
    assert topcon.run(0.999) == ["705#05"] * 9
    assert topcon.run(0.001) == ["585#8021200000000008", "705#05"]
