import asyncio
import os
import subprocess
import sys
import threading
import time

import can
import canopen
import pytest
import threaded_master
from canopen.nmt import NmtError

from simulators import Bench
from simulators.simulated_time import SimulatedTimeError, simulated_time
from simulators.simulated_time.wall import EPOCH
from simulators.slave import dictionary

FRAME = 111 / 500_000  # seconds of eight bytes on the wire


@pytest.fixture
def bench():
    return Bench("topcon", node_id=5, load="resistor 4")


@pytest.fixture
def inside(bench):
    """Simulated time that costs next to no time on the wall."""
    start = time.perf_counter()
    with simulated_time(bench, threaded_master):
        yield bench
    assert time.perf_counter() - start < 5


def connect(node_id=5, **config):
    network = canopen.Network().connect(interface="socketcan", channel="can0", **config)
    return network.add_node(node_id, dictionary("topcon.eds", node_id))


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
    inside.run(3600)
    assert node.nmt.state == "PRE-OPERATIONAL"
    assert len([frame for frame in inside.sent if frame == "705#7F"]) == 3600


def pair():
    return Bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})


def polled():
    """What a master with threads saw of two twins in two seconds, one of them dead for a while."""
    bench = pair()
    with simulated_time(bench, "threaded_master"):
        master = threaded_master.Master({n: dictionary("topcon.eds", n) for n in (5, 6)})
        bench.run(0.5)
        bench["left"].inject("lasting_error", number=0x23)
        bench["right"].power_off()
        bench.run(1.0)
        bench["right"].power_on()
        bench.run(0.5)
        master.close()
    readings = [poller.readings for poller in master.pollers]
    return readings, master.errors, [str(record) for record in bench.trace]


def test_a_master_with_threads_runs_on_the_bench():
    (left, right), errors, _ = polled()
    assert {value for _, value in left} == {400}
    assert [value for _, value in right].count(None) == 4  # 0.3 s each in a dead second
    assert errors == [(0.502222, 0x2300)]
    assert not [thread for thread in threading.enumerate() if "poller" in thread.name]


def test_a_master_with_threads_does_the_same_twenty_times():
    first = polled()
    assert all(polled() == first for _ in range(19))


def test_the_order_of_hashes_changes_nothing():
    code = "import hashlib, test_simulated_time as t; print(repr(t.polled()))"

    def seen(seed):
        path = os.pathsep.join(sys.path)
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": path}
        command = [sys.executable, "-c", code]
        return subprocess.run(command, env=environment, capture_output=True, check=True).stdout

    assert seen("0") == seen("1") == f"{polled()!r}\n".encode()


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


def test_a_bug_in_a_twin_reaches_the_test_also_from_a_thread_of_the_master(bench):
    bench.twin.node.device.stage.run = {}.popitem

    def write():
        with simulated_time(bench, threaded_master):
            node = connect()
            arguments = (0x2014, 0, b"\1\0")
            threaded_master.threading.Thread(target=node.sdo.download, args=arguments).start()
            bench.run(1.0)

    with pytest.raises(KeyError):
        write()


def test_an_exception_in_a_thread_of_the_master_is_reported_as_ever(inside, monkeypatch):
    reported = []
    monkeypatch.setattr(threading, "excepthook", lambda report: reported.append(report.exc_type))
    threaded_master.threading.Thread(target={}.popitem).start()
    inside.run(0.1)
    assert reported == [KeyError]


def test_threads_that_still_run_end_with_simulated_time(bench):
    before = threading.active_count()
    with simulated_time(bench, threaded_master):
        threaded_master.Master({5: dictionary("topcon.eds", 5)})
        bench.run(0.1)
        assert threading.active_count() == before + 3
    assert threading.active_count() == before


def real_world():
    found = {
        name: dict(vars(module))
        for name, module in list(sys.modules.items())
        if name.partition(".")[0] in {"can", "canopen", "threaded_master"}
    }
    return found, threaded_master.Poller.__bases__


def test_everything_is_as_before_afterwards_also_after_an_exception(bench):
    before, listeners = real_world(), list(bench.segment.listeners)
    with simulated_time(bench, threaded_master):
        assert real_world() != before
    assert real_world() == before
    with pytest.raises(ZeroDivisionError), simulated_time(bench, threaded_master):
        connect().sdo[0x2000].raw / 0
    assert real_world() == before
    assert bench.segment.listeners == listeners


def test_the_bench_goes_on_afterwards(bench):
    with simulated_time(bench):
        connect().sdo.upload(0x2000, 0)
    assert bench.run(1.0) == []
    assert bench.sdo["Nominal voltage"].raw == 400


def test_simulated_time_is_entered_once(inside):
    with pytest.raises(SimulatedTimeError, match="already"), simulated_time(Bench("topcon")):
        pass


def test_a_module_that_is_not_there_is_refused(bench):
    with pytest.raises(ImportError), simulated_time(bench, "no_such_module"):
        pass
    with simulated_time(bench):
        pass


def test_a_network_from_before_is_refused(bench):
    network = canopen.Network()
    with simulated_time(bench), pytest.raises(SimulatedTimeError, match="made before"):
        network.connect(channel="can0")


def test_a_node_from_before_is_refused(bench):
    node = canopen.RemoteNode(5, dictionary("topcon.eds", 5))
    with simulated_time(bench):
        network = canopen.Network()
        network.add_node(node)
        with pytest.raises(SimulatedTimeError, match="made before"):
            network.connect(channel="can0")


def test_what_was_made_inside_waits_no_more_afterwards(bench):
    with simulated_time(bench):
        node = connect(6)
    with pytest.raises(SimulatedTimeError, match="over"):
        node.nmt.wait_for_heartbeat(1)


def test_a_thread_in_real_time_is_refused_there_and_in_the_test(bench):
    refusals = []

    def read(node):
        try:
            node.sdo.upload(0x2000, 0)
        except SimulatedTimeError as refusal:
            refusals.append(str(refusal))

    def run():
        with simulated_time(bench):
            stranger = threading.Thread(target=read, args=(connect(),), name="stranger")
            stranger.start()
            stranger.join()

    with pytest.raises(SimulatedTimeError, match="'stranger' runs in real time"):
        run()
    assert "name the module" in refusals[0]


def test_an_event_loop_is_refused(inside):
    async def read():
        connect().sdo.upload(0x2000, 0)

    with pytest.raises(SimulatedTimeError, match="asyncio"):
        asyncio.run(read())


@pytest.fixture
def module():
    """Makes a module of the user from its source."""

    def module(source, name="users"):
        made = type(sys)(name)
        exec(source, vars(made))
        return made

    return module


@pytest.mark.parametrize(
    ("imported", "use", "named"),
    [
        ("import socket", "socket.create_connection(('127.0.0.1', 9))", "socket.create_connection"),
        ("from socket import socket", "socket()", "socket.socket"),
        ("import asyncio as a", "a.run(None)", "asyncio.runners.run"),
        ("import subprocess", "subprocess.run(['true'])", "subprocess.run"),
        ("import select", "select.select([], [], [])", "select.select"),
        ("from threading import Barrier", "Barrier(2)", "threading.Barrier"),
        (
            "from concurrent.futures import ThreadPoolExecutor",
            "ThreadPoolExecutor()",
            "concurrent.futures.thread.ThreadPoolExecutor",
        ),
    ],
)
def test_what_waits_elsewhere_is_refused_when_it_is_used(bench, module, imported, use, named):
    users = module(f"{imported}\ndef use(): {use}")
    with simulated_time(bench, users), pytest.raises(SimulatedTimeError, match=named):
        users.use()


def test_exceptions_and_constants_of_what_is_refused_can_be_used(bench, module):
    users = module("import socket, subprocess")
    with simulated_time(bench, users):
        assert users.socket.timeout is TimeoutError
        assert users.socket.AF_INET == 2
        assert users.subprocess.PIPE == -1


def test_a_loop_that_never_waits_is_refused(bench, module):
    users = module("import time\ndef spin():\n while time.time(): pass")
    with simulated_time(bench, users), pytest.raises(SimulatedTimeError, match="never waits"):
        users.spin()


def test_a_loop_around_a_sleep_of_nothing_gets_somewhere(bench, module):
    users = module("import time\ndef spin():\n while time.monotonic() < 0.01: time.sleep(0)")
    with simulated_time(bench, users):
        users.spin()
    assert bench.clock.now == pytest.approx(0.01)


def test_a_loop_that_asks_the_device_until_a_deadline_ends(bench, module):
    users = module("""
import time
def ask(node):
    while time.monotonic() < 1:
        node.sdo[0x2000].raw
""")
    with simulated_time(bench, users):
        users.ask(connect())
    assert bench.clock.now == pytest.approx(1.0, abs=0.001)


def test_a_wait_without_time_out_for_nothing_is_refused(bench, module):
    users = module("import threading\ndef wait(): threading.Event().wait()")
    with simulated_time(bench, users), pytest.raises(SimulatedTimeError, match="no time-out"):
        users.wait()


def test_a_thread_that_waits_in_real_time_is_found_and_shown(bench, module):
    users = module("import threading")
    never = threading.Event()

    def run():
        with simulated_time(bench, users, patience=0.1):
            users.threading.Thread(target=never.wait, name="stuck").start()
            bench.run(1.0)

    with pytest.raises(SimulatedTimeError, match=r"'stuck', at .*threading.py:\d+"):
        run()
    never.set()


def test_a_thread_that_gets_stuck_at_its_end_is_told_of_and_the_others_end(bench, module):
    users = module("""
import threading, time
def get_stuck(never):
    try:
        time.sleep(60)
    finally:
        never.wait()
""")
    never = threading.Event()
    ended = []

    def end():
        try:
            users.time.sleep(60)
        finally:
            ended.append(True)

    def run():
        with simulated_time(bench, users, patience=0.1):
            users.threading.Thread(target=users.get_stuck, args=(never,), name="stuck").start()
            users.threading.Thread(target=end).start()
            bench.run(1.0)

    with pytest.raises(SimulatedTimeError, match="'stuck'"):
        run()
    assert ended == [True]
    never.set()


def test_a_thread_that_cannot_be_ended_is_told_of(bench, module):
    users = module("""
import threading, time
def stubborn():
    while True:
        try:
            time.sleep(1)
        except:
            pass
""")

    def run():
        with simulated_time(bench, users):
            users.threading.Thread(target=users.stubborn).start()
            bench.run(3.0)

    with pytest.raises(SimulatedTimeError, match="cannot be ended"):
        run()


def test_a_thread_of_the_master_may_not_move_the_clock(bench, module):
    users = module("import threading, time")

    def run():
        with simulated_time(bench, users):
            users.threading.Thread(target=lambda: users.time.sleep(1)).start()
            users.threading.Thread(target=lambda: bench.run(2)).start()
            bench.run(1.0)

    with pytest.raises(SimulatedTimeError, match="may not move"):
        run()


def test_a_deadlock_of_the_master_is_no_hang(bench, module):
    users = module("import threading")
    with simulated_time(bench, users):
        lock = users.threading.Lock()
        lock.acquire()
        with pytest.raises(SimulatedTimeError, match="no time-out"):
            lock.acquire()
