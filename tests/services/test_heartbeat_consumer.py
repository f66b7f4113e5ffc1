import pytest
from probe import Probe, configure

from canopen_twins import Bench

WATCH_7 = "605#23161001E8030700"  # node 7 every 1000 ms
WATCH_9 = "605#23161002F4010900"  # node 9 every 500 ms


@pytest.fixture
def watching(bench):
    """Watches node 7 and has heard it at 0 s."""
    configure(bench, WATCH_7)
    bench.send("707#05")
    bench.device.told.clear()
    return bench


def told(bench):
    return [entry for entry in bench.device.told if isinstance(entry, str)]


def test_a_node_that_was_never_heard_is_not_missed(bench):
    configure(bench, WATCH_7)
    bench.device.told.clear()
    bench.run(10.0)
    assert told(bench) == []


def test_a_node_that_falls_silent_is_told_of_once(watching):
    watching.run(0.999)
    assert told(watching) == []
    watching.run(10.0)
    assert told(watching) == ["node 7 is silent"]


@pytest.mark.parametrize("state", ["00", "04", "05", "7F"])
def test_a_heartbeat_of_any_state_keeps_it_alive(watching, state):
    for _ in range(5):
        watching.run(0.9)
        watching.send(f"707#{state}")
    assert told(watching) == []


def test_a_node_that_is_back_is_told_of_once(watching):
    watching.run(2.0)
    watching.send("707#05")
    watching.run(0.5)
    watching.send("707#05")
    assert told(watching) == ["node 7 is silent", "node 7 is back"]


def test_it_is_told_at_the_moment_of_silence_and_what_comes_of_it_is_sent(watching):
    watching.run(2.0)
    assert str(watching.trace[-1]) == "(0000000001.000000) can0 085#3081110000000000"
    watching.send("707#05")
    assert watching.sent[-1] == "085#0000000000000000"


def test_time_has_passed_in_the_model_when_silence_is_told(watching):
    watching.run(2.0)
    assert watching.device.told[:2] == [1.0, "node 7 is silent"]


@pytest.mark.parametrize("frame", ["707#", "707#0505", "707#R", "00000707#05", "708#05"])
def test_what_is_no_heartbeat_of_the_node_does_not_keep_it_alive(watching, frame):
    watching.run(0.5)
    watching.send(frame)
    watching.run(0.6)
    assert told(watching) == ["node 7 is silent"]


def test_several_nodes_are_watched_each_in_its_own_time(watching):
    configure(watching, WATCH_9)
    watching.send("709#05")
    watching.run(0.6)
    assert told(watching) == ["node 9 is silent"]
    watching.run(0.6)
    assert told(watching) == ["node 9 is silent", "node 7 is silent"]


@pytest.mark.parametrize("entry", ["00000000", "E8030000", "00000700", "F4010900", "F4018700"])
def test_a_node_that_is_watched_no_more_is_not_missed(watching, entry):
    configure(watching, f"605#23161001{entry}")
    watching.run(2.0)
    assert told(watching) == []


def test_a_silent_node_that_is_watched_anew_is_back_with_its_next_heartbeat(watching):
    watching.run(2.0)
    configure(watching, "605#2316100100000000", WATCH_7)
    watching.send("707#05")
    assert told(watching) == ["node 7 is silent", "node 7 is back"]


def test_two_times_for_one_node_are_refused(watching):
    assert watching.send("605#23161002F4010700") == ["585#8016100243000406"]
    assert watching.send("605#4016100200000000") == ["585#4316100200000000"]
    configure(watching, "605#23161001F4010700", "605#2316100200000700")


def test_it_watches_in_every_state(watching):
    watching.send("000#0205")
    watching.device.told.clear()
    watching.run(2.0)
    assert told(watching) == ["node 7 is silent"]


@pytest.mark.parametrize(("node_id", "told_of"), [(1, True), (127, True), (128, False)])
def test_every_node_id_can_be_watched(bench, node_id, told_of):
    configure(bench, f"605#23161001E803{node_id:02X}00")
    bench.send(f"{0x700 + node_id % 128:03X}#05")
    bench.run(2.0)
    assert (f"node {node_id} is silent" in told(bench)) is told_of


def test_another_twin_is_watched_like_any_node():
    pair = Bench.of({"watching": Probe(5), "watched": Probe(7)})
    configure(pair, WATCH_7, "607#2B17100064000000")
    pair.run(5.0)
    assert told(pair["watching"]) == ["power on", "PRE-OPERATIONAL"]
    pair["watched"].power_off()
    pair.run(1.0)
    assert told(pair["watching"])[-1] == "node 7 is silent"
