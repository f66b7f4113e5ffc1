"""The same topics in real time, on a bus of python-can; a few of them, as they wait for real."""

import can
import canopen
import pytest

from canopen_twins import devices
from canopen_twins.conform import RealBus, conform, slave_of, tester, topics
from canopen_twins.live.twin import LiveTwin
from canopen_twins.scenario import Kind
from conform.full import write_full
from conform.local_node import NODE_ID, local_slave

TOPICS = {topic.number: topic for topic in topics()}


@pytest.fixture
def channel(request):
    return {"interface": "virtual", "channel": request.node.name}


def played(channel, slave, *numbers):
    """The outcomes of some topics in words."""
    bus = RealBus(lambda: can.Bus(**channel))
    try:
        verdict = conform(bus, slave, [TOPICS[number] for number in numbers])
    finally:
        bus.close()
    return {each.topic: each for each in verdict.outcomes}


def test_a_twin_in_real_time_passes_as_it_does_in_simulated_time(channel):
    slave = slave_of("topcon", devices.create("topcon", node_id=5))
    with LiveTwin("topcon", {"node_id": 5}, channel):
        found = played(channel, slave, "2.1", "2.13", "2.19", "3.13", "10.1")
    assert {number: each.seen for number, each in found.items() if each.kind is Kind.FAIL} == {}


@pytest.mark.usefixtures("quick_to_disconnect")
def test_a_local_node_fails_in_real_time_what_it_does_otherwise(channel, tmp_path, monkeypatch):
    monkeypatch.setattr(tester, "BOOT_TIME", 0.1)  # it does not tell that it boots
    eds = write_full(tmp_path)
    with canopen.Network().connect(**channel) as network:
        network.add_node(canopen.LocalNode(NODE_ID, str(eds)))
        network[NODE_ID].nmt.state = "PRE-OPERATIONAL"
        found = played(channel, local_slave(eds), "2.1", "2.5", "2.13", "3.20")
    assert [each.kind for each in found.values()] == [Kind.PASS, Kind.FAIL, Kind.PASS, Kind.FAIL]
