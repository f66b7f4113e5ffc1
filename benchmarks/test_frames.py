"""One frame, from its arrival at the node until its answer has left."""

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks import peers
from canopen_twins import devices
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect

FRAMES = {
    "foreign": Frame.parse("123#00"),
    "upload": Frame.parse("605#4020200000000000"),
    "download": Frame.parse("605#2B10200010000000"),
    "rpdo": Frame.parse("205#1000100010001000"),
    "rtr": Frame.parse("185#R"),
    "sync": Frame.parse("080#"),
}
ANSWERS = {"foreign": 0, "upload": 1, "download": 1, "rpdo": 0, "rtr": 1, "sync": 1}
TPDO1_ON_EVERY_SYNC = Frame.parse("605#2F00180201000000")
OPERATIONAL = Frame.parse("000#0105")


@pytest.fixture
def segment() -> Segment:
    """A TopCon in Operational, its output off and at rest, TPDO 1 of type 1."""
    segment = Segment()
    connect(segment, devices.create("topcon", node_id=peers.NODE_ID), "topcon").power_on()
    segment.deliver()
    segment.send(TPDO1_ON_EVERY_SYNC)
    segment.send(OPERATIONAL)
    segment.advance(1.0)
    return segment


@pytest.mark.parametrize("name", FRAMES)
def test_frame_twin(benchmark: BenchmarkFixture, segment: Segment, name: str):
    answers: list[Frame] = []
    segment.listeners.append(lambda frame, sender: answers.append(frame) if sender else None)
    segment.send(FRAMES[name])
    assert len(answers) == ANSWERS[name]
    segment.listeners.clear()
    benchmark(segment.send, FRAMES[name])


@pytest.mark.parametrize("name", ["foreign", "upload", "download"])
def test_frame_localnode(benchmark: BenchmarkFixture, name: str):
    network, frame = peers.muted(), FRAMES[name]
    benchmark(network.notify, frame.can_id, bytearray(frame.data), 0.0)
