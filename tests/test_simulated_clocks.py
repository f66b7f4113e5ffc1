"""What tells the time or waits by other names: simulated, or refused in words."""

import threading
import time
from types import ModuleType

import pytest

from canopen_twins import Bench
from canopen_twins.bench.simulated_time import SimulatedTimeError, simulated_time

HOUR = 3600
MASTER = """
import concurrent.futures
import sched
import threading
import time
from time import strftime


class Shared:
    lock = threading.Lock()


def clocks():
    return {
        "ctime": time.ctime(),
        "asctime": time.asctime(),
        "strftime": time.strftime("%Y-%m-%d %H:%M:%S"),
        "imported": strftime("%Y-%m-%d %H:%M:%S"),
        "real": time.clock_gettime(time.CLOCK_REALTIME),
        "monotonic": time.clock_gettime(time.CLOCK_MONOTONIC),
        "nanoseconds": time.clock_gettime_ns(time.CLOCK_MONOTONIC),
    }


def hand_over():
    Shared.lock.acquire()
    threading.Timer(5, Shared.lock.release).start()
    Shared.lock.acquire()
    return time.monotonic()


def wait_by_a_schedule():
    schedule, done = sched.scheduler(), []
    schedule.enter(HOUR, 1, lambda: done.append(time.monotonic()))
    schedule.run()
    return done


def pool():
    return concurrent.futures.ThreadPoolExecutor()
"""


@pytest.fixture
def master():
    module = ModuleType("master_of_clocks")
    module.HOUR = HOUR
    exec(compile(MASTER, "master_of_clocks.py", "exec"), vars(module))
    lock = module.Shared.lock
    with simulated_time(Bench("topcon", node_id=5), module):
        yield module
    assert module.Shared.lock is lock
    assert module.threading is threading


def test_every_clock_tells_the_time_of_the_bench(master):
    before = master.clocks()
    master.time.sleep(HOUR)
    after = master.clocks()
    for name in ("real", "monotonic"):
        assert after[name] - before[name] == pytest.approx(HOUR)
    assert after["nanoseconds"] - before["nanoseconds"] == HOUR * 10**9
    for name, text in (("ctime", "%c"), ("asctime", "%c")):
        told = [time.mktime(time.strptime(each[name], text)) for each in (before, after)]
        assert told[1] - told[0] == HOUR
    assert after["strftime"] == after["imported"] != before["strftime"]


def test_a_time_that_is_given_is_told_as_it_is(master):
    assert master.time.ctime(0) == time.ctime(0)
    assert master.time.strftime("%Y", time.gmtime(0)) == "1970"
    assert master.time.asctime(time.gmtime(0)) == "Thu Jan  1 00:00:00 1970"


def test_what_a_process_has_used_is_of_the_real_world(master):
    assert master.time.clock_gettime(time.CLOCK_PROCESS_CPUTIME_ID) > 0


def test_a_lock_that_a_class_shares_is_waited_for_in_simulated_time(master):
    assert master.hand_over() == pytest.approx(5)


def test_a_schedule_waits_in_simulated_time(master):
    assert master.wait_by_a_schedule() == [pytest.approx(HOUR)]


def test_a_pool_of_threads_is_refused_by_its_module_too(master):
    with pytest.raises(SimulatedTimeError, match=r"use threading\.Thread and queue\.Queue"):
        master.pool()
