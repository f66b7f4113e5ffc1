import tracemalloc
from functools import partial
from math import inf, nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canopen_twins.bus.clock import FEW_TIMERS, Clock, Scope, Timer


@pytest.fixture
def clock():
    return Clock()


def test_actions_fire_in_the_order_of_their_deadlines(clock):
    fired = []
    for delay in (0.3, 0.1, 0.2):
        clock.after(delay, lambda delay=delay: fired.append(delay))
    clock.advance(1.0)
    assert fired == [0.1, 0.2, 0.3]


def test_equal_deadlines_fire_in_the_order_they_were_set(clock):
    fired = []
    for name in "abc":
        clock.at(0.5, lambda name=name: fired.append(name))
    clock.advance(0.5)
    assert fired == ["a", "b", "c"]


def test_now_is_the_deadline_while_an_action_runs_and_the_end_afterwards(clock):
    seen = []
    clock.after(0.25, lambda: seen.append(clock.now))
    clock.advance(1.0)
    assert (seen, clock.now) == ([0.25], 1.0)


def test_time_is_counted_in_whole_microseconds(clock):
    seen = []
    clock.at(0.3, lambda: seen.append(clock.now))
    clock.advance(0.1)
    clock.advance(0.2)  # 0.1 + 0.2 > 0.3 in floating point
    assert (seen, clock.ticks) == ([0.3], 300_000)


def test_an_action_due_exactly_at_the_end_fires_and_one_a_microsecond_later_does_not(clock):
    fired = []
    clock.at_tick(1_000_000, lambda: fired.append("at"))
    clock.at_tick(1_000_001, lambda: fired.append("after"))
    clock.advance(1.0)
    assert fired == ["at"]


def test_a_time_that_has_passed_is_due_at_once_and_does_not_turn_the_clock_back(clock):
    clock.advance(2.0)
    seen = []
    clock.at(1.0, lambda: seen.append(clock.now))
    clock.advance(0.0)
    assert seen == [2.0]


def test_an_action_may_set_another_for_the_same_moment(clock):
    fired = []
    clock.after(0.1, lambda: clock.after(0.0, lambda: fired.append(clock.now)))
    clock.advance(0.1)
    assert fired == [0.1]


def test_a_series_goes_on_as_long_as_its_action_says_when(clock):
    fired, following = [], iter([1100, 1350, None, 2000])

    def action():
        fired.append(clock.ticks)
        return next(following)

    clock.series(1000, action)
    clock.advance(1.0)
    assert fired == [1000, 1100, 1350]


def test_a_series_may_be_cancelled_by_its_own_action(clock):
    fired = []

    def end():
        fired.append(clock.ticks)
        series.cancel()
        return clock.ticks + 1

    series = clock.series(1000, end)
    clock.advance(1.0)
    assert fired == [1000]


def test_a_cancelled_action_does_not_fire(clock):
    timer = clock.after(0.1, lambda: pytest.fail("cancelled"))
    assert timer.pending
    timer.cancel()
    assert not timer.pending
    assert clock.next_deadline == inf
    clock.advance(1.0)


def test_a_timer_is_pending_until_it_has_fired(clock):
    timer = clock.after(0.1, lambda: None)
    clock.advance(0.1)
    assert not timer.pending


@settings(max_examples=20)
@given(st.integers(1, 5_000_000), st.lists(st.floats(0.0, 0.7), max_size=20))
def test_a_period_does_not_drift_however_the_time_is_cut_up(period, pieces):
    clock, seen = Clock(), []
    clock.every(period / 1_000_000, lambda: seen.append(clock.ticks))
    for piece in pieces:
        clock.advance(piece)
        assert seen == [*range(period, clock.ticks + 1, period)]


def test_every_ends_when_it_is_cancelled_from_its_own_action(clock):
    fired = []

    def stop():
        fired.append(clock.now)
        if len(fired) == 2:
            timer.cancel()

    timer = clock.every(0.1, stop)
    clock.advance(1.0)
    assert fired == [0.1, 0.2]


def test_a_period_below_a_microsecond_is_refused(clock):
    with pytest.raises(ValueError, match="shorter than a microsecond"):
        clock.every(0.000_000_4, lambda: None)


@pytest.mark.parametrize("time", [inf, nan])
def test_the_clock_does_not_advance_for_ever(clock, time):
    with pytest.raises(ValueError, match="cannot advance"):
        clock.advance(time)


def test_the_next_deadline_is_that_of_the_earliest_pending_action(clock):
    early = clock.at(0.1, lambda: None)
    clock.at(0.2, lambda: None)
    assert clock.next_deadline == 0.1
    early.cancel()
    assert (clock.next_deadline, clock.next_tick) == (0.2, 200_000)


def test_something_can_be_done_after_each_action_at_its_time(clock):
    seen = []
    for time in (0.1, 0.2):
        clock.at(time, lambda: seen.append("action"))
    clock.advance_to(1.0, lambda: seen.append(clock.now))
    assert seen == ["action", 0.1, "action", 0.2]


def test_an_action_knows_whether_it_would_be_the_next(clock):
    seen = []
    clock.at(0.2, lambda: None)
    clock.at(0.1, lambda: seen.extend(map(clock.is_free, (199_999, 200_000))))
    clock.at(0.3, lambda: seen.extend(map(clock.is_free, (400_000, 400_001))))
    clock.advance_to(0.4)
    assert seen == [True, False, True, False]
    assert not clock.is_free(400_001)  # nobody lets time pass


@pytest.mark.parametrize(
    ("other", "end", "after"),
    [
        (1.0, 2.0, 1.0),  # an action that is due there comes before
        (0.9, 2.0, 0.8),
        (0.31, 2.0, 0.4),  # no whole period
        (0.2, 2.0, 0.4),
        (5.0, 2.0, 2.0),  # who lets time pass may act at the end
        (5.0, 0.3, 0.4),
    ],
)
def test_periods_in_which_nothing_happens_can_be_left_out(clock, other, end, after):
    seen = []
    clock.at(0.2, lambda: seen.append(clock.after_idling(200_000)))
    clock.at(other, lambda: None)
    clock.advance_to(end)
    assert seen == [round(after * 1_000_000)]
    assert clock.after_idling(10) == clock.ticks + 10


def test_an_action_goes_on_without_a_timer(clock):
    fired = []

    def act():
        fired.append(clock.now)
        if clock.is_free(clock.ticks + 100_000):
            clock.go_on(clock.ticks + 100_000)
            act()

    clock.at(0.1, act)
    clock.at(0.35, lambda: fired.append("other"))
    clock.advance_to(1.0)
    assert fired == [0.1, 0.2, 0.3, "other"]
    assert clock.now == 1.0


def test_an_error_in_an_action_reaches_the_caller(clock):
    clock.after(0.1, lambda: {}["missing"])
    with pytest.raises(KeyError, match="missing"):
        clock.advance(1.0)


def test_the_timers_of_a_scope_end_with_it_and_no_others(clock):
    fired = []
    scope, other = Scope(clock), Scope(clock)
    scope.after(0.1, lambda: fired.append("once"))
    scope.every(0.1, lambda: fired.append("again"))
    other.after(0.3, lambda: fired.append("other"))
    clock.advance(0.15)
    scope.close()
    clock.advance(1.0)
    assert fired == ["once", "again", "other"]


def test_a_scope_does_not_collect_timers_that_are_over(clock):
    scope = Scope(clock)
    for _ in range(100):
        scope.after(1.0, lambda: None).cancel()
        scope.after(0.0, lambda: None)
        clock.advance(0.0)
    scope.every(1.0, lambda: None)
    assert len(scope._timers) <= FEW_TIMERS
    assert scope.now == clock.now


def test_a_scope_can_surround_each_of_its_actions(clock):
    log = []

    def run(action):
        log.append("before")
        action()
        log.append("after")

    scope = Scope(clock, run)
    scope.after(0.1, lambda: log.append("once"))
    scope.every(0.2, lambda: log.append("again"))
    clock.advance(0.2)
    assert log == ["before", "once", "after", "before", "again", "after"]


def test_a_timer_of_a_scope_costs_as_much_beside_thousands_as_alone(monkeypatch, clock):
    looks = []
    monkeypatch.setattr(Timer, "pending", property(lambda timer: looks.append(timer) or True))
    scope = Scope(clock)
    for _ in range(2000):
        scope.after(1.0, lambda: None)
    assert len(looks) <= 2 * 2000


def test_a_timer_that_is_cancelled_takes_no_memory_until_its_time(clock):
    tracemalloc.start()
    for _ in range(20_000):
        clock.after(3600.0, list).cancel()
        clock.advance(0.001)
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert grown < 100_000


def test_what_is_pending_comes_in_order_whatever_is_cancelled_beside_it(clock):
    told = []
    for number in range(500):
        clock.at_tick(1000, partial(told.append, number))
        clock.at_tick(500 + number, list).cancel()
    clock.advance(0.001)
    assert told == [*range(500)]
