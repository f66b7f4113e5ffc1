import threading
from queue import Empty, Full

import pytest

from canopen_twins import Bench
from canopen_twins.bench.simulated_time import simulated_time

NAMES = "import queue, threading, time"


@pytest.fixture
def bench():
    return Bench("topcon")


@pytest.fixture
def world(bench):
    """What a module of the user sees; `log` is a list of (time, text)."""
    users = type(threading)("users")
    exec(NAMES, vars(users))
    with simulated_time(bench, users):
        users.log = []
        users.say = lambda text: users.log.append((round(users.time.monotonic(), 6), text))
        yield users


def start(world, *targets):
    threads = [world.threading.Thread(target=target) for target in targets]
    for thread in threads:
        thread.start()
    return threads


def test_a_lock_is_waited_for(world):
    lock = world.threading.Lock()

    def hold():
        with lock:
            world.time.sleep(1)

    def take():
        assert not lock.acquire(blocking=False)
        assert not lock.acquire(timeout=0.25)
        world.say("late")
        with lock:
            world.say("mine")

    first, second = start(world, hold, take)
    first.join()
    second.join()
    assert world.log == [(0.25, "late"), (1.0, "mine")]
    assert not lock.locked()


def test_a_lock_is_released_by_who_holds_it(world):
    with pytest.raises(RuntimeError):
        world.threading.Lock().release()
    with pytest.raises(RuntimeError):
        world.threading.RLock().release()


def test_an_rlock_is_held_as_often_as_it_was_taken(world):
    lock = world.threading.RLock()

    def take():
        with lock:
            world.say("mine")

    with lock:
        with lock:
            (other,) = start(world, take)
            world.time.sleep(1)
        world.time.sleep(1)
    other.join()
    assert world.log == [(2.0, "mine")]


def test_a_condition_wakes_those_who_wait_in_their_order(world):
    condition = world.threading.Condition()

    def wait(name):
        def wait():
            with condition:
                world.say(f"{name} {condition.wait(3)}")

        return wait

    threads = start(world, wait("first"), wait("second"), wait("third"))
    world.time.sleep(1)
    with condition:
        condition.notify()
    world.time.sleep(1)
    with condition:
        condition.notify()
    for thread in threads:
        thread.join()
    assert world.log == [(1.0, "first True"), (2.0, "second True"), (3.0, "third False")]


def test_a_condition_lets_its_lock_go_while_it_waits_however_often_it_is_held(world):
    condition = world.threading.Condition()

    def act():
        world.time.sleep(1)
        with condition:
            condition.notify_all()

    start(world, act)
    with condition, condition:
        assert condition.wait(2)
    assert world.time.monotonic() == 1.0


def test_a_condition_shares_a_lock_that_is_given(world):
    lock = world.threading.Lock()
    condition = world.threading.Condition(lock)
    condition.acquire()
    assert lock.locked()
    condition.release()
    for act in (condition.wait, condition.notify):
        with pytest.raises(RuntimeError):
            act()


def test_a_condition_waits_for_something_to_be_true(world):
    condition, found = world.threading.Condition(), []

    def act():
        for item in range(3):
            world.time.sleep(1)
            with condition:
                found.append(item)
                condition.notify_all()

    start(world, act)
    with condition:
        assert condition.wait_for(lambda: len(found) == 2)
        assert world.time.monotonic() == 2.0
        assert not condition.wait_for(lambda: len(found) == 4, timeout=2.5)
    assert world.time.monotonic() == 4.5


def test_an_event_is_waited_for(world):
    event = world.threading.Event()
    world.threading.Timer(1.0, event.set).start()
    assert not event.wait(0.5)
    assert event.wait(5)
    assert world.time.monotonic() == 1.0
    event.clear()
    assert not event.is_set()


def test_a_timer_that_is_cancelled_does_nothing(world):
    timer = world.threading.Timer(1.0, world.say, args=("never",))
    timer.start()
    timer.cancel()
    timer.join()
    assert world.log == []


def test_a_semaphore_lets_so_many_in(world):
    semaphore = world.threading.Semaphore(2)

    def work():
        with semaphore:
            world.time.sleep(1)
            world.say("done")

    for thread in start(world, work, work, work):
        thread.join()
    assert world.log == [(1.0, "done"), (1.0, "done"), (2.0, "done")]
    assert semaphore.acquire()
    assert semaphore.acquire()
    assert not semaphore.acquire(blocking=False)
    assert not semaphore.acquire(timeout=1)


def test_a_bounded_semaphore_has_a_bound(world):
    semaphore = world.threading.BoundedSemaphore(1)
    with semaphore:
        pass
    with pytest.raises(ValueError, match="too many"):
        semaphore.release()


def test_a_thread_is_what_python_says_it_is(world):
    seen = []
    (thread,) = start(world, lambda: (world.time.sleep(1), seen.append(threading.current_thread())))
    assert thread.is_alive()
    thread.join(0.5)
    assert thread.is_alive()
    thread.join()
    assert not thread.is_alive()
    assert seen == [thread]


def test_a_thread_is_started_once_and_joined_by_others_when_it_has_started(world):
    reported = []

    def join_itself():
        with pytest.raises(RuntimeError) as refusal:
            thread.join()
        reported.append(str(refusal.value))

    thread = world.threading.Thread(target=join_itself)
    with pytest.raises(RuntimeError, match="before it is started"):
        thread.join()
    assert not thread.is_alive()
    thread.start()
    thread.join()
    assert reported == ["cannot join current thread"]
    with pytest.raises(RuntimeError, match="once"):
        thread.start()


def test_threads_may_start_threads(world):
    def parent():
        world.time.sleep(1)
        (child,) = start(world, lambda: (world.time.sleep(1), world.say("child")))
        child.join()
        world.say("parent")

    (thread,) = start(world, parent)
    thread.join()
    assert world.log == [(2.0, "child"), (2.0, "parent")]


def test_a_queue_is_waited_for_on_both_ends(world):
    queue = world.queue.Queue(maxsize=1)

    def consume():
        while (item := queue.get()) is not None:
            world.time.sleep(1)
            world.say(item)
            queue.task_done()

    (consumer,) = start(world, consume)
    for item in "abc":
        queue.put(item)
    queue.join()
    assert world.log == [(1.0, "a"), (2.0, "b"), (3.0, "c")]
    queue.put(None)
    consumer.join()


def test_a_queue_is_full_or_empty_after_its_time_out(world):
    queue = world.queue.Queue(maxsize=1)
    with pytest.raises(Empty):
        queue.get(timeout=1)
    with pytest.raises(Empty):
        queue.get_nowait()
    queue.put(1)
    with pytest.raises(Full):
        queue.put(2, timeout=1)
    with pytest.raises(Full):
        queue.put_nowait(2)
    assert world.time.monotonic() == 2.0


@pytest.mark.parametrize(
    ("kind", "order"),
    [
        ("Queue", [2, 1, 3]),
        ("SimpleQueue", [2, 1, 3]),
        ("LifoQueue", [3, 1, 2]),
        ("PriorityQueue", [1, 2, 3]),
    ],
)
def test_every_queue_has_its_order(world, kind, order):
    queue = getattr(world.queue, kind)()
    for item in (2, 1, 3):
        queue.put(item)
    assert [queue.get(timeout=1) for _ in order] == order


def test_dates_begin_with_the_year_2000(world):
    world.time.sleep(86_400)
    assert world.time.gmtime()[:4] == (2000, 1, 2, 0)
    assert world.time.gmtime(0)[:4] == (1970, 1, 1, 0)
    assert world.time.localtime() == world.time.localtime(world.time.time())
    assert world.time.perf_counter_ns() == 86_400_000_000_000
    assert world.time.strftime("%Y", world.time.gmtime()) == "2000"


def test_a_negative_sleep_is_refused(world):
    with pytest.raises(ValueError, match="non-negative"):
        world.time.sleep(-1)


def test_locks_that_do_not_wait_work_when_simulated_time_is_over(bench):
    users = type(threading)("users")
    exec(NAMES, vars(users))
    with simulated_time(bench, users):
        lock, queue, event = users.threading.RLock(), users.queue.Queue(), users.threading.Event()
    with lock:
        queue.put(1)
        event.set()
    assert queue.get() == 1
    assert event.wait()


def test_what_a_module_made_at_its_import_waits_in_simulated_time_in_every_module(bench):
    users, others = type(threading)("users"), type(threading)("others")
    made = "lock, rlock, idle, going, jobs = Lock(), RLock(), Event(), Event(), Queue(2)"
    exec(f"from threading import *\nfrom queue import Queue\n{made}\n", vars(users))
    users.going.set()
    users.jobs.put("job")
    real = vars(others)["lock"] = users.lock
    with simulated_time(bench, users, others):
        assert others.lock is users.lock
        assert users.lock.acquire()
        assert not users.lock.acquire(timeout=1)
        with users.rlock, users.rlock:
            assert not users.idle.wait(1)
        assert users.going.wait(1)
        assert users.jobs.get(timeout=1) == "job"
        with pytest.raises(Empty):
            users.jobs.get(timeout=1)
        assert users.jobs.maxsize == 2
    assert bench.clock.now == 3.0
    assert users.lock is others.lock is real
    assert not real.locked()
