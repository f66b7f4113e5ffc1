import pytest
from probe import Probe, configure

from canopen_twins import Bench

EVERY_100_MS = "605#2B17100064000000"


@pytest.mark.spec("T-060")
def test_without_a_period_there_is_no_heartbeat(bench):
    assert bench.run(100.0) == []


@pytest.mark.spec("T-061")
def test_the_first_heartbeat_comes_a_period_after_the_write(bench):
    bench.run(0.05)
    configure(bench, EVERY_100_MS)
    assert bench.run(0.099) == []
    assert bench.run(0.001) == ["705#7F"]


@pytest.mark.spec("T-061")
@pytest.mark.parametrize("period", [1, 7, 1000, 65535])
def test_the_period_is_in_milliseconds_and_does_not_drift(bench, period):
    configure(bench, f"605#2B171000{period.to_bytes(2, 'little').hex()}0000")
    start = len(bench.trace)
    bench.run(10 * period / 1000)
    times = [record.time for record in bench.trace[start:]]
    assert times == [n * period / 1000 for n in range(1, 11)]


@pytest.mark.spec("T-062")
def test_it_shows_the_state_at_the_moment_it_is_sent(bench):
    configure(bench, EVERY_100_MS)
    sent = []
    for command in ("000#0105", "000#0205", "000#8005"):
        bench.run(0.05)
        bench.send(command)
        sent += [frame for frame in bench.run(0.05) if frame.startswith("705")]
    assert sent == ["705#05", "705#04", "705#7F"]


def test_a_change_of_state_sends_no_heartbeat_of_its_own(bench):
    configure(bench, EVERY_100_MS)
    bench.run(0.05)
    assert bench.send("000#0205") == []


@pytest.mark.spec("T-063")
def test_writing_0_stops_it(bench):
    configure(bench, EVERY_100_MS)
    bench.run(0.25)
    configure(bench, "605#2B17100000000000")
    assert bench.run(1.0) == []


def test_a_new_period_counts_from_its_write(bench):
    configure(bench, EVERY_100_MS)
    bench.run(0.05)
    configure(bench, "605#2B171000C8000000")
    assert bench.run(0.199) == []
    assert bench.run(0.001) == ["705#7F"]


@pytest.mark.spec("T-064")
@pytest.mark.parametrize("reset", ["000#8105", "000#8205"])
def test_after_a_reset_the_period_of_the_dictionary_holds(bench, reset):
    configure(bench, EVERY_100_MS)
    bench.run(0.05)
    assert bench.send(reset) == ["705#00"]
    assert bench.run(1.0) == []


def test_a_stored_period_is_in_force_from_the_boot_up_on(bench):
    configure(bench, EVERY_100_MS, "605#2310100173617665")
    bench.run(0.05)
    bench.send("000#8205")
    assert bench.run(0.099) == []
    assert bench.run(0.001) == ["705#7F"]


def test_a_period_of_the_dictionary_is_in_force_from_the_boot_up_on():
    class Beating(Probe):
        def dictionary(self):
            od = super().dictionary()
            od[0x1017].default = 100
            return od

    bench = Bench.of({"probe": Beating()})
    assert bench.run(0.2) == ["705#7F", "705#7F"]


def test_the_profile_says_whether_the_first_comes_with_the_write(bench_of):
    bench = bench_of(first_heartbeat_at_once=True)
    assert sorted(bench.send(EVERY_100_MS)) == ["585#6017100000000000", "705#7F"]
    assert bench.run(0.1) == ["705#7F"]
    assert bench.send("605#2B17100000000000") == ["585#6017100000000000"]


def test_the_profile_says_what_the_period_is_rounded_to(bench_of):
    bench = bench_of(heartbeat_period=lambda milliseconds: milliseconds // 16 * 0.016)
    configure(bench, EVERY_100_MS)
    bench.run(0.2)
    assert [record.time for record in bench.trace[-2:]] == [0.096, 0.192]
    assert bench.sdo["Producer heartbeat"].raw == 100


def test_node_guarding_is_not_answered(bench):
    assert bench.send("705#R") == []
