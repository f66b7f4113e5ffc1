from itertools import permutations

import pytest

from canopen_twins.bus.frame import Frame, length
from canopen_twins.bus.segment import priority

from .conftest import READ_VOLTAGE, SYNC

ANSWER, PDO = "585#4B20200000000000", "185#0000000000000000"
IN_ORDER = ["080#", "185#", "185#R", "06140000#", "06140001#", "585#", "705#05"]


def micro(*frames, bit_rate=125_000):
    """Seconds that frames take one after the other."""
    return sum(round(length(Frame.parse(text)) / bit_rate, 6) for text in frames)


def test_a_frame_arrives_when_it_is_over(topcon):
    topcon.segment.limit(125_000)
    assert topcon.send(READ_VOLTAGE) == []
    both = micro(READ_VOLTAGE, ANSWER)
    assert 0.0016 < both < 0.0022  # 111..135 bits of 8 us each, twice
    assert topcon.run(both - 1e-6) == []
    assert topcon.run(1e-6) == [ANSWER]


def test_the_lowest_identifier_of_those_that_wait_wins(topcon):
    topcon.segment.limit(125_000)
    for text in ("7E0#", READ_VOLTAGE, SYNC, "081#"):
        topcon.send(text)
    topcon.run(0.02)
    order = [str(record.frame) for record in topcon.trace[-6:]]
    assert order == ["7E0#", SYNC, "081#", PDO, READ_VOLTAGE, ANSWER]


@pytest.mark.parametrize("seed", range(5))
def test_priority_is_that_of_the_arbitration_field(seed):
    frames = [Frame.parse(text) for text in IN_ORDER]
    shuffled = list(permutations(frames))[seed * 1000 + 17]
    assert sorted(shuffled, key=priority) == frames


def test_a_load_of_high_priority_holds_a_node_up_one_of_low_priority_by_a_frame_only(topcon):
    def delay(cob_id):
        topcon.inject("bus_load", percent=99, kilobits=125, cob_id=cob_id)
        topcon.run(0.05)
        start = topcon.clock.now
        topcon.send(READ_VOLTAGE)
        while str(topcon.trace[-1].frame) != ANSWER:
            topcon.run(0.0001)
        topcon.clear()
        topcon.run(0.5)
        return topcon.clock.now - 0.5 - start

    topcon.segment.limit(125_000)
    assert delay(0x7FE) < 0.005
    assert delay(0x001) > 0.02


def test_without_a_bit_rate_frames_take_no_time(topcon):
    assert topcon.send(READ_VOLTAGE) == [ANSWER]
