import asyncio
import gc
import sys
import threading
import time
import weakref

import canopen
import pytest
import threaded_master
from threaded_master import connect

from canopen_twins import Bench
from canopen_twins.bench.limits import Standstill
from canopen_twins.bench.simulated_time import SimulatedTimeError, scheduler, simulated_time
from canopen_twins.slave.dictionary import dictionary


@pytest.fixture
def bench():
    return Bench("topcon", node_id=5, load="resistor 4")


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


def test_nothing_is_kept_of_a_bench_whose_master_never_disconnects():
    bench = Bench("topcon", node_id=5)
    with simulated_time(bench):
        connect().sdo.upload(0x2000, 0)
    segment = weakref.ref(bench.segment)
    del bench
    gc.collect()
    assert segment() is None


def test_simulated_time_is_entered_once(bench):
    entered = simulated_time(Bench("topcon"))
    with simulated_time(bench), pytest.raises(SimulatedTimeError, match="already"), entered:
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


def test_an_event_loop_is_refused(bench):
    async def read():
        connect().sdo.upload(0x2000, 0)

    with simulated_time(bench), pytest.raises(SimulatedTimeError, match="asyncio"):
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
        with pytest.raises(SimulatedTimeError, match="a lock that it holds itself"):
            lock.acquire()


def test_threads_that_hold_each_other_up_are_found(bench, module):
    users = module("""
import threading, time
one, other = threading.Lock(), threading.Lock()
def take(first, second):
    with first:
        time.sleep(1)
        with second:
            pass
""")

    def run():
        with simulated_time(bench, users):
            users.threading.Thread(target=users.take, args=(users.one, users.other)).start()
            users.threading.Thread(target=users.take, args=(users.other, users.one)).start()
            bench.run(2.0)

    with pytest.raises(SimulatedTimeError, match=r"deadlock of threads .*:7 in take and .*:7 in t"):
        run()


def test_endless_retries_are_over_after_a_limit_of_simulated_time(bench, module):
    users = module("""
import canopen
def start(node):
    while True:
        try:
            node.sdo["Run command"].raw = 1
            return
        except Exception:
            pass
""")
    bench.power_off()
    with (
        pytest.raises(SimulatedTimeError, match=r"60 s of simulated time: it is at .*:6 in start"),
        simulated_time(bench, users, longest=60),
    ):
        users.start(connect())
    assert 60 < bench.clock.now < 61


def test_a_loop_that_never_waits_is_over_after_a_limit_of_real_time(bench, module):
    users = module("def spin():\n try:\n  while True: pass\n except Exception: pass")
    with (
        pytest.raises(SimulatedTimeError, match=r"\d s of real time.*: it is at .*:3 in spin"),
        simulated_time(bench, users, wall=0.05),
    ):
        users.spin()


def test_a_limit_of_real_time_counts_the_time_in_which_there_was_a_core(bench, module):
    users = module("def wait(event):\n while not event.wait(0.001): pass")
    with (
        pytest.raises(
            SimulatedTimeError, match=r"0.2 s of real time, of which .* had a core for 0\.0"
        ),
        simulated_time(bench, wall=0.1),
    ):
        users.wait(threading.Event())


def test_a_thread_that_never_waits_is_told_of_and_ended(bench, module):
    users = module("import threading\ndef spin():\n while True: pass")

    def run():
        with simulated_time(bench, users, patience=0.05):
            thread = users.threading.Thread(target=users.spin, name="spinning")
            spinning.append(thread)
            thread.start()
            bench.run(1.0)

    spinning = []
    with pytest.raises(SimulatedTimeError, match=r"thread 'spinning', at .*:3 in spin has not"):
        run()
    threading.Thread.join(spinning[0], 5.0)
    assert not threading.Thread.is_alive(spinning[0])


@pytest.mark.parametrize("what", ["bus.send(can.Message(data=[1]))", "bus.recv(0)"])
def test_a_loop_around_a_bus_that_never_waits_is_refused(bench, module, what, monkeypatch):
    users = module(f"import can\ndef spin(bus):\n while True: {what}")
    with (
        pytest.raises(SimulatedTimeError, match=r"never waits, at .*:3 in spin"),
        simulated_time(bench, users),
    ):
        spin_on_a_bus(users, monkeypatch)


def spin_on_a_bus(users, monkeypatch):
    monkeypatch.setattr(scheduler.in_force(), "_standstill", Standstill(1000))
    users.spin(users.can.Bus())


def test_a_spinning_thread_that_catches_what_it_is_told_ends(bench, module, monkeypatch):
    users = module("""
import threading, time
def spin():
    while True:
        try:
            time.monotonic()
        except Exception:
            pass
""")

    def run():
        with simulated_time(bench, users):
            monkeypatch.setattr(scheduler.in_force(), "_standstill", Standstill(1000))
            users.threading.Thread(target=users.spin).start()
            bench.run(1.0)

    with pytest.raises(SimulatedTimeError, match="asks for the time and never waits"):
        run()


def test_a_sleep_in_real_time_is_refused(bench):
    real = time.sleep
    with (
        simulated_time(bench),
        pytest.raises(SimulatedTimeError, match=r"ends.py:\d+ in test_a"),
    ):
        time.sleep(1)
    assert time.sleep is real
    with simulated_time(bench):
        stranger = threading.Thread(target=time.sleep, args=(0,))  # whoever is not of the test
        stranger.start()
        stranger.join()
