import canopen
import pytest

from .declared import U8, U16, bench_of, entry, record

GUARDING = entry("100C", U16, 100) + entry("100D", U8, 3)  # life: 300 ms
ERROR_BEHAVIOUR = record("1029", (U8, 0))
LOST, BACK = "085#3081110000000000", "085#0000000000000000"


@pytest.fixture
def bench(tmp_path):
    return bench_of(tmp_path, GUARDING + ERROR_BEHAVIOUR)


@pytest.fixture
def operational(bench):
    bench.send("000#0105")
    return bench


def test_the_state_is_told_with_a_bit_that_alternates(bench):
    assert [*bench.send("705#R"), *bench.send("705#R"), *bench.send("705#R")] == [
        "705#7F",
        "705#FF",
        "705#7F",
    ]
    bench.send("000#0105")
    assert bench.send("705#R") == ["705#85"]
    bench.send("000#0205")
    assert bench.send("705#R") == ["705#04"]


@pytest.mark.parametrize(("command", "answer"), [("82", "7F"), ("81", "7F"), ("80", "FF")])
def test_only_a_reset_sets_the_bit_back(bench, command, answer):
    bench.send("705#R")
    bench.send(f"000#{command}05")
    assert bench.send("705#R") == [f"705#{answer}"]


def test_a_file_without_a_guard_time_does_not_guard(tmp_path):
    assert bench_of(tmp_path).send("705#R") == []


def test_a_node_with_heartbeats_is_not_guarded(bench):
    bench.send("605#2B171000E8030000")
    assert bench.send("705#R") == []
    bench.send("605#2B17100000000000")
    assert bench.send("705#R") == ["705#7F"]


def test_life_guarding_begins_with_the_first_request(operational):
    assert operational.run(10.0) == []
    operational.send("705#R")
    assert operational.run(0.299) == []
    assert operational.run(0.002) == [LOST]


def test_requests_in_time_keep_it_alive(operational):
    for _ in range(10):
        operational.send("705#R")
        assert operational.run(0.25) == []


def test_it_is_over_with_the_next_request(bench):
    bench.send("705#R")
    bench.run(1.0)
    assert bench.send("705#R") == ["705#FF", BACK]
    assert bench.run(1.0) == [LOST]


@pytest.mark.parametrize("index", ["0C", "0D"])
def test_without_a_life_time_nothing_is_watched(bench, index):
    bench.send("705#R")
    size = {"0C": "2B", "0D": "2F"}[index]
    bench.send(f"605#{size}{index}100000000000")
    assert bench.run(10.0) == []
    bench.send("705#R")
    assert bench.run(10.0) == []


def test_another_life_time_counts_from_the_next_request(bench):
    bench.send("705#R")
    bench.send("605#2F0D100005000000")
    assert bench.run(10.0) == []
    bench.send("705#R")
    assert bench.run(0.499) == []
    assert bench.run(0.002) == [LOST]


@pytest.mark.parametrize(("behaviour", "state"), [(0, "7F"), (1, "05"), (2, "04")])
def test_the_error_behaviour_says_which_state_follows(operational, behaviour, state):
    operational.send(f"605#2F291001{behaviour:02X}000000")
    operational.send("705#R")
    assert operational.run(1.0) == [LOST]
    assert operational.send("705#R")[0][:6] == f"705#{int(state, 16) | 0x80:02X}"


def test_without_an_error_behaviour_operational_is_left(tmp_path):
    bench = bench_of(tmp_path, GUARDING)
    bench.send("000#0105")
    bench.send("705#R")
    bench.run(1.0)
    assert bench.state == "PRE-OPERATIONAL"


def test_an_error_leaves_a_stopped_node_stopped(bench):
    bench.send("000#0205")
    bench.send("705#R")
    assert bench.run(1.0) == []
    assert bench.state == "STOPPED"


def test_a_behaviour_that_is_none_is_refused(bench):
    assert bench.send("605#2F29100103000000") == ["585#8029100130000906"]


def test_canopens_master_guards(bench):
    states = []
    bench.remote.nmt.add_heartbeat_callback(states.append)
    bench.remote.nmt.start_node_guarding(0.1)
    bench.run(0.35)
    bench.remote.nmt.stop_node_guarding()
    assert states == [0x7F] * 3
    assert isinstance(bench.remote, canopen.RemoteNode)
    assert bench.run(1.0) == [LOST]
