"""Each topic is passed by a twin that has the service; who is known to err fails."""

import logging
from collections import Counter
from contextlib import suppress
from random import Random

import pytest

from canopen_twins import Bench, devices
from canopen_twins.bus.segment import Segment
from canopen_twins.conform import conform, conform_twin, slave_of, topics
from canopen_twins.conform.bus import SimulatedBus
from canopen_twins.errors import UserError
from canopen_twins.scenario import Kind
from conform.full import write_full
from conform.local_node import NODE_ID, conform_local, local_slave

NOT_GUARDED = "7.20"
TOPICS = {topic.number: topic for topic in topics()}

OF_LOCAL_NODE = {
    "2.5": "reading 0x1000:01 is carried out instead of 06090011h",
    "2.10": "0x2003:00 := 6500 is carried out",
    "2.11": "0x2003:00 := 0900 is carried out",
    "2.19": "60h is refused with 08000000h instead of 05040001h",
    "2.25": "585#4300100000000000 answers four bytes",
    "2.26": "585#4108100015000000 is no answer to a block transfer",
    "3.5": "no 185 in 1 s",
    "3.7": "0 in 1 s with an event timer of 100 ms",
    "3.9": "TPDOs at three SYNCs: [0, 0, 0] instead of [1, 1, 1]",
    "3.13": "TPDOs for one request: 0 instead of 1",
    "3.20": "0x1800:02 := F1h is carried out",
    "3.21": "205 is not taken without SYNC",
    "3.30": "0x1400:01 := 204h is carried out",
    "3.32": "0x1A00:00 := 2h is carried out",
    "3.33": "mapping 0x1000:00 is carried out",
    "4.5": "0x2003:00 := 6500 is carried out",
    "5.6": "0x1003:00 := 1h is carried out",
    "6.4": "0 in 1 s with a period of 100000 us",
    "6.7": "0x1019:00 := 1h is carried out",
    "7.9": "0x1016:02 := 7E0190h is carried out",
    "7.10": "no EMCY 8130h in 1 s without heartbeat",
    "7.17": "no 705 in 1 s",
    "8.2": "0x1010:01 := 65766153h is carried out",
    "8.7": "0x1400:01 := 1h is carried out",
    "9.1": "no 705 in 0.3 s",
    "9.4": "SDO is answered",
    "10.1": "no 705 in 0.3 s",
    "11.1": "no 7E4 in 1 s",
}
"""What canopen's LocalNode is seen to do by topics that it fails."""
LOCAL_NODE_CAN = ("2.1", "2.2", "2.3", "2.4", "2.6", "2.8", "2.13", "2.14", "2.15", "2.16", "7.3")


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    return write_full(tmp_path_factory.mktemp("full"))


def test_the_twin_of_a_file_with_every_service_passes_every_topic(full):
    verdict = conform_twin("drive", devices.create(full, node_id=5))
    others = [str(each) for each in verdict.outcomes if each.kind is not Kind.PASS]
    (outcome,) = [each for each in verdict.outcomes if each.kind is not Kind.PASS]
    assert (outcome.topic, outcome.seen) == (
        NOT_GUARDED,
        "not applicable: there is guarding (EDS)",
    ), others


def test_who_is_not_guarded_is_silent():
    (outcome,) = conform_twin("topcon", devices.create("topcon"), [TOPICS[NOT_GUARDED]]).outcomes
    assert outcome.kind is Kind.PASS


@pytest.mark.parametrize("number", OF_LOCAL_NODE)
def test_a_local_node_fails_what_it_does_otherwise(full, number, caplog):
    caplog.set_level(logging.CRITICAL, "canopen")
    (outcome,) = conform_local(full, [TOPICS[number]]).outcomes
    assert outcome.kind is Kind.FAIL
    assert outcome.seen.startswith(OF_LOCAL_NODE[number])
    assert outcome.scene


def test_a_local_node_passes_what_it_can(full):
    verdict = conform_local(full, [TOPICS[number] for number in LOCAL_NODE_CAN])
    assert [(each.topic, each.seen) for each in verdict.outcomes if each.kind is Kind.FAIL] == []


def test_a_slave_that_is_not_there_is_wrong_input():
    slave = slave_of("topcon", devices.create("topcon", node_id=5))
    with pytest.raises(UserError, match="node 5 answers no SDO request: is topcon there"):
        conform(SimulatedBus(Segment()), slave)


def mangled(random, frame):
    """The same frame with another length, or with other data."""
    data = bytearray(frame.data)
    if data and random.random() < 0.6:
        data[random.randrange(len(data))] = random.randrange(256)
    elif random.random() < 0.5:
        data = data[: random.randrange(9)]
    else:
        data = data.ljust(8, b"\xff")
    return frame._replace(data=bytes(data))


@pytest.mark.parametrize("seed", range(2))
def test_every_topic_ends_whatever_a_slave_answers(full, seed):
    random, bench = Random(seed), Bench(full, node_id=NODE_ID)
    bus, slave = SimulatedBus(bench.segment), local_slave(full)

    def mangle(frame, onward):
        onward(mangled(random, frame) if random.random() < 0.15 else frame)

    bench.twin.node.wire.outgoing.append(mangle)
    seen = Counter()
    for topic in topics():
        with suppress(UserError):  # not even the device type was answered
            seen.update(each.kind for each in conform(bus, slave, [topic]).outcomes)
    assert min(seen[Kind.FAIL], seen[Kind.PASS]) > 15
