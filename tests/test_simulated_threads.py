import os
import subprocess
import sys
import threading
import time

import pytest
import threaded_master
from threaded_master import connect

from canopen_twins import Bench
from canopen_twins.bench.simulated_time import simulated_time
from canopen_twins.slave.dictionary import dictionary


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
    code = "import hashlib, test_simulated_threads as t; print(repr(t.polled()))"

    def seen(seed):
        path = os.pathsep.join(sys.path)
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": path}
        command = [sys.executable, "-c", code]
        return subprocess.run(command, env=environment, capture_output=True, check=True).stdout

    assert seen("0") == seen("1") == f"{polled()!r}\n".encode()


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
        assert threading.active_count() == before + 3 + 1  # which watches for the end
    assert threading.active_count() == before
