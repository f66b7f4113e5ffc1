import pytest

from canopen_twins import Bench
from canopen_twins.bus import sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.diagnosis.why import why

NAME, VENDOR, STATE = (
    "605#4008100000000000",
    "605#4018100100000000",
    "605#4001100000000000",
)


@pytest.fixture
def slow():
    return lambda **given: Bench("tests/probe.eds", node_id=5, **given)


def answers(bench, seconds):
    start = len(bench.trace)
    bench.run(seconds)
    return [(round(each.time, 6), str(each.frame)) for each in bench.trace[start:]]


def test_an_answer_takes_its_time(slow):
    bench = slow(answer_time=0.01)
    assert bench.send(STATE) == []
    assert bench.run(0.009999) == []
    assert bench.run(0.000001) == ["585#4F01100000000000"]


def test_in_ideal_it_is_there_before_time_moves(slow):
    assert slow().send(STATE) == ["585#4F01100000000000"]


def test_the_jitter_is_in_its_range_and_the_same_with_the_same_seed(slow):
    def times(**given):
        bench = slow(answer_time=0.01, answer_jitter=0.005, **given)
        found = []
        for _ in range(20):
            asked = bench.clock.now
            bench.send(STATE)
            ((time, _),) = answers(bench, 0.05)
            found.append(round(time - asked, 6))
        return found

    assert times() == times()
    assert times() != times(seed=2)
    assert 0.01 <= min(times()) < max(times()) <= 0.015


def test_a_request_meanwhile_waits_and_the_next_overwrites_it(slow):
    bench = slow(answer_time=0.01)
    for request in (NAME, VENDOR, STATE):
        bench.send(request)
    (first, second) = answers(bench, 1.0)
    assert first[1][:12] == "585#41081000"
    assert second == (0.02, "585#4F01100000000000")


def test_or_all_of_them_wait(slow):
    bench = slow(answer_time=0.01, busy_request="waits")
    for _ in range(3):
        bench.send(STATE)
    assert [time for time, _ in answers(bench, 1.0)] == [0.01, 0.02, 0.03]


def test_even_then_there_is_an_end(slow):
    bench = slow(answer_time=0.001, busy_request="waits")
    for _ in range(2000):
        bench.send(STATE)
    assert len(bench.run(10.0)) == 33


def test_what_is_written_acts_when_it_is_answered(slow):
    bench = slow(answer_time=0.01)
    bench.send("605#2B171000E8030000")
    assert bench.values("Producer heartbeat") == {"Producer heartbeat": 0}
    assert answers(bench, 1.01) == [(0.01, "585#6017100000000000"), (1.01, "705#7F")]


def test_a_reset_forgets_what_waits(slow):
    bench = slow(answer_time=0.01)
    bench.send(STATE)
    bench.send(NAME)
    assert bench.send("000#8105") == ["705#00"]
    assert bench.run(1.0) == []


def test_a_stopped_node_forgets_it_too(slow):
    bench = slow(answer_time=0.01)
    bench.send(STATE)
    bench.send("000#0205")
    assert bench.run(1.0) == []
    bench.send("000#8005")
    assert bench.run(1.0) == []


def test_why_says_that_a_request_was_overwritten(slow):
    bench = slow(answer_time=0.01)
    for request in (NAME, VENDOR, STATE):
        bench.send(request)
    bench.run(1.0)
    told = why(bench.node, bench.trace)
    assert f"{VENDOR} not answered: overwritten by the next request" in "\n".join(told)


def test_the_segments_of_a_block_do_not_wait_for_each_other(slow):
    bench = slow(answer_time=0.01)
    value = bytes(range(200))
    named = sdo.multiplexer((0x2006, 0))
    head = sdo.message(sdo.Ccs.BLOCK_DOWNLOAD, named + len(value).to_bytes(4, "little"), 2)
    bench.put(Frame(0x605, head))
    bench.run(0.1)
    count = -(-len(value) // 7)
    for number in range(count):
        bench.put(Frame(0x605, sdo.block_segment(value, number, number + 1)))
    ((time, confirmed),) = answers(bench, 0.1)
    assert time == 0.11
    last = f"{count:02X}"
    assert confirmed[:8] == f"585#A2{last}"


@pytest.mark.parametrize("device", ["topcon", "charger", "gateway"])
def test_every_device_has_it(device):
    bench = Bench(device, node_id=5, answer_time=0.01)
    bench.run(2.0)
    assert bench.send(STATE) == []
    assert [text[:8] for text in bench.run(0.1) if text.startswith("585")] == ["585#4F01"]
