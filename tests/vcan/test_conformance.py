"""The conformance test on a real bus: a twin in a process of its own, and canopen's LocalNode."""

import can
import canopen
import pytest

from canopen_twins import devices
from canopen_twins.conform import RealBus, conform, slave_of, tester, topics
from canopen_twins.files.shipped import od_file
from canopen_twins.scenario import Kind
from tests.vcan.bus import CHANNEL

pytestmark = pytest.mark.vcan

TOPICS = {topic.number: topic for topic in topics()}
PLAYED = ("2.1", "2.5", "2.13", "3.13", "9.1")


@pytest.fixture
def outcomes():
    """How topics end against node 5 of the bus, which should be a TopCon."""

    def outcomes():
        bus = RealBus(lambda: can.Bus(interface="socketcan", channel=CHANNEL))
        try:
            slave = slave_of("topcon", devices.create("topcon", node_id=5))
            verdict = conform(bus, slave, [TOPICS[number] for number in PLAYED])
        finally:
            bus.close()
        return {each.topic: each.kind for each in verdict.outcomes}

    return outcomes


def test_a_twin_passes(run, outcomes):
    run("topcon", 5)
    assert outcomes() == dict.fromkeys(PLAYED, Kind.PASS)


def test_a_local_node_neither_boots_nor_sends_a_pdo_when_asked(stack, outcomes, monkeypatch):
    monkeypatch.setattr(tester, "BOOT_TIME", 0.3)
    network = stack.enter_context(canopen.Network().connect(interface="socketcan", channel=CHANNEL))
    with od_file("topcon.eds") as eds:
        network.add_node(canopen.LocalNode(5, str(eds)))
    assert outcomes() == {
        "2.1": Kind.PASS,
        "2.5": Kind.FAIL,
        "2.13": Kind.PASS,
        "3.13": Kind.FAIL,
        "9.1": Kind.FAIL,
    }
