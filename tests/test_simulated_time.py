import time

import can
import canopen
import pytest
import threaded_master
from canopen.nmt import NmtError
from threaded_master import connect

from canopen_twins import Bench
from canopen_twins.bench.simulated_time import simulated_time
from canopen_twins.bench.simulated_time.primitives import EPOCH
from canopen_twins.bus.frame import length

FRAME = 111 / 500_000  # seconds of eight bytes on the wire


@pytest.fixture
def bench():
    return Bench("topcon", node_id=5, load="resistor 4")


@pytest.fixture
def inside(bench):
    """Simulated time: an hour of it would run into the time limit if it were spent on the wall."""
    with simulated_time(bench, threaded_master):
        yield bench


@pytest.fixture
def node(inside):
    """The twin as an unmodified master sees it."""
    return connect()


def at(bench, seconds, act):
    bench.clock.at(seconds, lambda: (act(), bench.segment.deliver()))


def test_an_unmodified_master_connects_to_the_bench_and_is_answered(inside, node):
    assert node.sdo["Nominal voltage"].raw == 400
    node.sdo["Voltage reference"].raw = 2000
    assert inside.sdo["Voltage reference"].raw == 2000
    assert inside.trace[-1].sender == "topcon"


def test_what_the_master_sends_is_in_the_trace_with_its_name(inside, node):
    node.nmt.state = "OPERATIONAL"
    assert str(inside.trace[-1]) == "(0000000000.000000) can0 000#0105"
    assert inside.trace[-1].sender == "master 1"


def test_an_answer_takes_its_time_on_the_wire(inside, node):
    assert node.sdo["Nominal voltage"].raw == 400
    assert inside.clock.now == pytest.approx(FRAME, abs=1e-6)
    slow = connect(bitrate=10_000)
    assert slow.sdo["Nominal voltage"].raw == 400
    assert inside.clock.now == pytest.approx(FRAME + 111 / 10_000, abs=1e-6)


def test_on_a_bus_with_a_bit_rate_request_and_answer_take_their_time_once(inside, node):
    inside.segment.limit(500_000)
    assert node.sdo["Nominal voltage"].raw == 400
    request, answer = (record.frame for record in inside.trace[-2:])
    taken = (length(request) + length(answer)) / 500_000
    assert inside.clock.now == pytest.approx(taken, abs=1e-6)


def test_a_time_out_passes_in_simulated_time_only(inside):
    nobody = connect(6)
    start = time.perf_counter()
    with pytest.raises(canopen.SdoCommunicationError, match="No SDO response"):
        nobody.sdo.upload(0x1000, 0)
    assert inside.clock.now == 0.3
    assert time.perf_counter() - start < 0.2


def test_retries_take_their_time_each(inside):
    nobody = connect(6)
    nobody.sdo.MAX_RETRIES = 3
    with pytest.raises(canopen.SdoCommunicationError):
        nobody.sdo.upload(0x1000, 0)
    assert inside.clock.now == pytest.approx(0.9)
    assert [str(record.frame)[:4] for record in inside.trace[-4:]] == ["606#"] * 4  # one aborts


def test_the_boot_up_is_waited_for(inside, node):
    inside.power_off()
    at(inside, 3.0, inside.power_on)
    node.nmt.wait_for_bootup(10)
    assert inside.clock.now == pytest.approx(3.0 + 55 / 500_000, abs=1e-6)


def test_a_boot_up_that_does_not_come_is_missed_in_simulated_time(inside, node):
    with pytest.raises(NmtError):
        node.nmt.wait_for_bootup(10)
    assert 10 < inside.clock.now < 11


def test_the_heartbeat_is_waited_for(inside, node):
    node.sdo["Producer Heartbeat Time"].raw = 500
    assert node.nmt.wait_for_heartbeat(2) == "PRE-OPERATIONAL"
    inside.power_off()
    with pytest.raises(NmtError):
        node.nmt.wait_for_heartbeat(2)
    assert inside.clock.now == pytest.approx(2.5, abs=0.001)


def test_an_emergency_is_waited_for_also_one_that_does_not_come(inside, node):
    at(inside, 2.0, lambda: inside.inject("lasting_error", number=0x23))
    assert node.emcy.wait(0x2300, 10).code == 0x2300
    assert inside.clock.now == pytest.approx(2.0, abs=0.001)
    assert node.emcy.wait(0x2300, 10) is None
    assert inside.clock.now == pytest.approx(12.0, abs=0.001)


def test_a_pdo_is_waited_for(inside, node):
    node.tpdo.read()
    node.nmt.state = "OPERATIONAL"
    at(inside, 7.0, lambda: inside.send("185#R"))
    stamp = node.tpdo[1].wait_for_reception(10)
    assert inside.clock.now == pytest.approx(7.0, abs=0.001)
    assert stamp == pytest.approx(EPOCH + 7.0, abs=0.001)
    assert node.tpdo[1].wait_for_reception(1) is None


def test_sync_is_sent_on_time_and_no_more_when_it_is_stopped(inside, node):
    node.network.sync.start(0.1)
    inside.run(0.35)
    node.network.sync.stop()
    inside.run(1.0)
    sent = [record.time for record in inside.trace if record.frame.can_id == 0x80]
    assert sent == [0.0, 0.1, 0.2, 0.3]


def test_lss_waits_in_simulated_time(inside, node):
    found, _ = node.network.lss.fast_scan()
    assert not found
    assert inside.clock.now == node.network.lss.RESPONSE_TIMEOUT


def test_a_late_answer_hits_the_next_request_as_it_does_on_a_bus(inside, node):
    inside.send("000#0205")  # stopped: no SDO
    at(inside, 0.31, lambda: inside.send("585#4B1020000000FFFF"))
    with pytest.raises(canopen.SdoCommunicationError, match="No SDO response"):
        node.sdo.upload(0x2010, 0)
    with pytest.raises(canopen.SdoCommunicationError, match="0x2010"):
        node.sdo.upload(0x2000, 0)


def test_an_answer_comes_when_the_device_is_back_before_the_time_out(inside, node):
    inside.send("000#0205")
    at(inside, 0.2, lambda: inside.send("585#4B00200090010000"))
    assert node.sdo["Nominal voltage"].raw == 400
    assert inside.clock.now == pytest.approx(0.2, abs=0.001)


def test_the_module_of_the_user_sleeps_and_looks_at_its_clocks_in_simulated_time(inside):
    assert threaded_master.a_minute_later() == [60, 60, 60, 60e9, 60e9]
    assert inside.clock.now == 60


def test_an_hour_with_a_heartbeat_is_over_in_no_time(inside, node):
    node.sdo["Producer Heartbeat Time"].raw = 1000
    start = time.perf_counter()
    inside.run(3600)
    assert time.perf_counter() - start < 36  # less than 1 s where nobody else is at work
    assert node.nmt.state == "PRE-OPERATIONAL"
    assert len([frame for frame in inside.sent if frame == "705#7F"]) == 3600


def test_a_callback_runs_in_the_thread_of_python_can_and_cannot_wait_for_an_answer(inside, node):
    failures = []

    def read(_):
        try:
            node.sdo.upload(0x2000, 0)
        except canopen.SdoCommunicationError as failure:
            failures.append(str(failure))

    node.emcy.add_callback(read)
    inside.inject("lasting_error", number=0x23)
    inside.run(1.0)
    assert failures == ["No SDO response received"]  # as on a real bus: nobody can receive it


def test_two_networks_of_one_master_hear_each_other(inside, node):
    heard = []
    connect(6).network.subscribe(0x123, lambda can_id, data, time: heard.append(bytes(data)))
    node.network.send_message(0x123, b"hi")
    inside.run(0.01)
    assert heard == [b"hi"]


def test_a_bus_without_canopen_waits_too_and_filters(inside):
    with can.Bus(channel="can0", can_filters=[{"can_id": 0x585, "can_mask": 0x7FF}]) as bus:
        request = bytes.fromhex("4000200000000000")
        bus.send(can.Message(arbitration_id=0x605, data=request, is_extended_id=False))
        at(inside, 1.0, lambda: inside.send("123#"))
        assert bus.recv(2).arbitration_id == 0x585
        assert bus.recv(2) is None
    assert inside.clock.now == pytest.approx(2.0, abs=0.001)
    with pytest.raises(can.CanOperationError, match="shut down"):
        bus.send(can.Message())


def test_a_rest_of_a_time_out_that_rounding_leaves_is_waited_for(inside):
    with can.Bus() as bus:
        assert [bus.recv(1 / 3) for _ in range(3)] == [None] * 3
    assert inside.clock.now == pytest.approx(1.0, abs=1e-5)


def test_what_a_bench_cannot_carry_is_refused(inside):
    with pytest.raises(can.CanOperationError, match=r"CAN 2\.0"), can.Bus() as bus:
        bus.send(can.Message(is_fd=True))
