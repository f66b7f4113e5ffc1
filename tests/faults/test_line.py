from random import Random

import pytest
from canopen import SdoCommunicationError

from canopen_twins import UserError
from canopen_twins.bus.frame import Frame, length

from .conftest import READ_VERSION, READ_VOLTAGE, SYNC

BEAT, ANSWER = "705#05", "585#4B20200000000000"


def test_frames_are_lost_on_their_way_out(topcon):
    topcon.inject("frame_lost", frame="585#4B2020*")
    assert topcon.send(READ_VOLTAGE) == []
    with pytest.raises(SdoCommunicationError):
        _ = topcon.sdo["Actual voltage"].raw
    assert topcon.sdo["Actual current"].raw == 0


def test_frames_are_lost_on_their_way_in(topcon):
    topcon.inject("frame_lost", frame="000#81xx", times=1)
    assert topcon.send("000#8105") == []
    assert topcon.send("000#8105") == ["705#00"]


def test_every_frame_is_meant_if_none_is_named(topcon):
    topcon.inject("frame_lost")
    assert (topcon.send(READ_VOLTAGE), topcon.send(SYNC), topcon.run(1.0)) == ([], [], [])


def test_a_frame_arrives_twice(topcon):
    topcon.inject("frame_doubled", frame="705#*")
    assert topcon.run(0.1) == [BEAT, BEAT]
    topcon.inject("frame_doubled", frame="605#*")
    assert topcon.send(READ_VOLTAGE) == [ANSWER, ANSWER]


def test_a_frame_arrives_late_and_others_overtake_it(topcon):
    topcon.inject("frame_late", frame="185#*", seconds=0.15)
    assert topcon.send(SYNC) == []
    assert topcon.run(0.15) == [BEAT, "185#0000000000000000"]


def test_a_frame_that_is_heard_late_is_answered_late(topcon):
    topcon.inject("frame_late", frame="605#*", seconds=0.05)
    assert topcon.send(READ_VOLTAGE) == []
    assert topcon.run(0.05) == [ANSWER]


def test_a_frame_and_the_next_like_it_change_places(topcon, active):
    topcon.inject("frame_swapped", frame="585#*", times=1)
    assert topcon.send(READ_VOLTAGE) == []
    assert active() == ["frame_swapped"]
    assert topcon.send("605#4017100000000000") == ["585#4B17100064000000", ANSWER]
    assert active() == []
    assert topcon.send(READ_VOLTAGE) == [ANSWER]


def test_what_waits_for_the_next_is_lost_when_the_fault_is_cleared(topcon):
    topcon.inject("frame_swapped", frame="585#*")
    topcon.send(READ_VOLTAGE)
    topcon.clear()
    assert topcon.send(READ_VOLTAGE) == [ANSWER]


@pytest.mark.parametrize("bits", [1, 3, 64])
def test_bits_are_inverted(topcon, bits):
    topcon.inject("frame_corrupt", frame="585#*", bits=bits)
    (sent,) = topcon.send(READ_VOLTAGE)
    assert (int(sent[4:], 16) ^ int(ANSWER[4:], 16)).bit_count() == bits


def test_frames_without_data_cannot_be_corrupted(topcon):
    topcon.inject("frame_corrupt", frame="080#")
    assert topcon.send(SYNC) == ["185#0000000000000000"]


def test_frames_jitter_and_none_overtakes_another(topcon):
    topcon.inject("frame_jitter", frame="585#*", seconds=0.01)
    segments = ["605#6000000000000000", "605#7000000000000000"]
    for request in (READ_VERSION, *segments):
        assert topcon.send(request) == []
    assert topcon.run(0.01) == [
        "585#410A100008000000",
        "585#0056342E31312E34",
        "585#1D35000000000000",
    ]


def test_losses_come_in_bursts_by_seeded_chance(topcon):
    def trace(seed):
        topcon.inject("frame_lost", frame="585#*", probability=0.05, burst=5, seed=seed)
        return "".join(str(len(topcon.send(READ_VOLTAGE))) for _ in range(400))

    first = trace(7)
    assert first == trace(7) != trace(8)
    assert [run for run in first.split("1") if run].count("00000") > 5
    assert first.count("0") < 200


def test_all_that_an_error_passive_node_sends_is_late_and_in_order(topcon):
    topcon.inject("error_passive", seconds=0.01)
    for request in (READ_VOLTAGE, SYNC, READ_VOLTAGE):
        assert topcon.send(request) == []
    assert topcon.run(0.01) == [ANSWER, "185#0000000000000000", ANSWER]


def test_a_node_that_is_bus_off_comes_back_as_it_was(topcon, active):
    topcon.inject("bus_off", seconds=1.05)
    assert topcon.send("000#8105") == []
    assert topcon.run(1.05) == []
    assert active() == []
    assert topcon.run(0.1) == [BEAT]


def test_a_node_is_bus_off_until_it_is_cleared(topcon, active):
    topcon.inject("bus_off")
    assert (topcon.run(60.0), active()) == ([], ["bus_off"])
    topcon.clear()
    assert topcon.send(READ_VOLTAGE) == [ANSWER]


@pytest.mark.parametrize(("percent", "kilobits"), [(50, 250), (100, 125), (5, 1000)])
def test_frames_of_others_take_a_share_of_the_bus(topcon, percent, kilobits):
    topcon.inject("bus_load", percent=percent, kilobits=kilobits, cob_id=0x7F0)
    assert topcon.run(1.0).count(BEAT) == 10
    load = [record.frame for record in topcon.trace if record.sender == "load"]
    assert {frame.can_id for frame in load} == {0x7F0}
    assert sum(map(length, load)) == pytest.approx(10 * percent * kilobits, rel=0.01)
    assert str(topcon.sent).count("7F0#") == 0
    topcon.clear()
    topcon.trace.clear()
    topcon.run(1.0)
    assert {record.sender for record in topcon.trace} == {"topcon"}


def test_a_frame_is_as_long_as_its_bits_and_those_stuffed():
    assert length(Frame.parse("000#")) == 47 + 34 // 5  # 34 zeros, those of the CRC included
    chance = Random(1)
    for size in range(9):
        lengths = {
            length(Frame(chance.randrange(0x800), chance.randbytes(size))) for _ in range(99)
        }
        shortest = 47 + 8 * size
        assert shortest <= min(lengths) < max(lengths) <= shortest + (33 + 8 * size) // 4
    assert length(Frame(0x18DA00F1, bytes(8), extended=True)) > 131


@pytest.mark.parametrize("text", ["185", "1x5#00x", "8xx#*", "185#00*00", "hello"])
def test_what_is_no_look_of_a_frame_is_refused(topcon, active, text):
    with pytest.raises(UserError, match=r"is no frame|identifiers end|at most 8 bytes"):
        topcon.inject("frame_lost", frame=text)
    assert active() == []


def test_faults_of_all_levels_compose(topcon, active):
    topcon.inject("frame_doubled", frame="705#*")
    topcon.inject("heartbeat_late", seconds=0.01)
    topcon.inject("heartbeat_wrong_state", state=0x7F)
    topcon.inject("frame_lost", frame="705#7F", times=1)
    assert active() == ["frame_doubled", "heartbeat_late", "heartbeat_wrong_state", "frame_lost"]
    assert topcon.run(0.1) == []
    assert topcon.run(0.01) == ["705#7F"]
    topcon.clear("heartbeat_wrong_state")
    assert topcon.run(0.1) == [BEAT, BEAT]
    assert active() == ["frame_doubled", "heartbeat_late"]
