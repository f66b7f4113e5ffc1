import pytest

from .declared import U8, U32, bench_of, entry, record

WATCHING = record("1016", (U32, ""), (U32, ""))
WATCH_7 = "605#23161001C8000700"  # node 7 every 200 ms
WATCH_9 = "605#23161002C8000900"
LOST, BACK = "085#3081110000000000", "085#0000000000000000"
PASSIVE, RECOVERED = "085#2081110000000000", "085#4081110000000000"


@pytest.fixture
def bench(tmp_path):
    return bench_of(tmp_path, WATCHING + record("1029", (U8, "")))


@pytest.fixture
def watching(bench):
    """Operational; watches node 7, which it has heard."""
    bench.send(WATCH_7)
    bench.send("000#0105")
    bench.send("707#05")
    return bench


def test_a_silent_node_is_told_and_operational_is_left(watching):
    assert watching.run(0.199) == []
    assert watching.run(1.0) == [LOST]
    assert watching.state == "PRE-OPERATIONAL"
    assert watching.sdo[0x1001].raw == 0x11


def test_its_next_heartbeat_is_the_end_of_the_error(watching):
    watching.run(1.0)
    assert watching.send("707#05") == [BACK]
    assert watching.sdo[0x1001].raw == 0


def test_each_silent_node_is_told_and_the_end_of_all(watching):
    watching.send(WATCH_9)
    watching.send("709#05")
    assert watching.run(1.0) == [LOST, LOST]
    assert watching.send("707#05") == []
    assert watching.send("709#05") == [BACK]


def test_a_silent_node_that_is_watched_no_more_is_no_error(watching):
    watching.run(1.0)
    assert watching.send("605#2316100100000000") == ["585#6016100100000000", BACK]


def test_a_boot_up_does_not_begin_the_watch(bench):
    bench.send(WATCH_7)
    bench.send("707#00")
    assert bench.run(1.0) == []


def test_stopped_is_entered_after_the_emergency(watching):
    watching.send("605#2F29100102000000")
    assert watching.run(1.0) == [LOST]
    assert watching.state == "STOPPED"


def test_bus_off_is_told_once_it_is_over(watching):
    watching.send("605#2316100100000000")
    watching.inject("bus_off", seconds=0.5)
    assert watching.run(0.499) == []
    assert watching.run(0.1) == [RECOVERED, BACK]
    assert watching.state == "PRE-OPERATIONAL"


def test_bus_off_that_is_cleared_is_told(bench):
    bench.inject("bus_off")
    bench.run(1.0)
    bench.clear("bus_off")
    assert [*bench.sent[1:], *bench.run(0.1)] == [RECOVERED, BACK]


def test_an_error_passive_controller_is_told_while_it_is(bench):
    bench.inject("error_passive", seconds=0.001)
    assert bench.run(0.1) == [PASSIVE]
    bench.clear("error_passive")
    assert bench.sent[-1] == BACK
    assert bench.state == "PRE-OPERATIONAL"


def test_a_controller_that_recovers_by_itself_is_told(bench):
    bench.inject("error_passive", seconds=0.001, times=2)
    bench.send("605#2B17100064000000")
    assert bench.run(0.35) == [PASSIVE, "585#6017100000000000", BACK, *["705#7F"] * 3]


def test_the_history_has_them(tmp_path):
    bench = bench_of(tmp_path, record("1003", (U32, ""), (U32, "")))
    bench.inject("error_passive")
    bench.clear("error_passive")
    assert bench.sdo[0x1003][1].raw == 0x8120


@pytest.mark.parametrize("fault", ["bus_off", "error_passive"])
def test_a_device_of_python_tells_what_its_manual_says(bench_of, fault):
    bench = bench_of()
    bench.inject(fault)
    bench.run(1.0)
    bench.clear(fault)
    assert bench.run(1.0) == []


def test_a_cob_id_of_emergencies_that_the_file_leaves_out_is_the_standard_one(tmp_path):
    bench = bench_of(tmp_path, entry("1014", U32, ""))
    assert bench.send("605#4014100000000000") == ["585#4314100085000000"]
