"""Runs in other processes, some of which die."""

import io
import os
from functools import partial

import pytest

from canopen_twins.bench.limits import BUSY
from canopen_twins.errors import UserError
from canopen_twins.hunt import contract, workers
from canopen_twins.hunt.workers import AHEAD, DEATHS, Pool, _receive, _send

from .errands import (
    break_down,
    die,
    die_once,
    double,
    hang,
    hang_in_c,
    meet,
    refuse,
)


def taken(asked):
    for number in range(100):
        asked.append(number)
        yield number


@pytest.fixture
def pool():
    """Two processes."""
    with Pool(2, lost=lambda item, death: f"{item} was lost: {death.words}", patience=60) as pool:
        yield pool


def test_what_takes_as_long_as_twenty_others_keeps_nobody_from_these(pool, tmp_path):
    assert 2 * AHEAD > 20
    os.mkfifo(tmp_path / "pipe")
    assert [*pool(partial(meet, tmp_path / "pipe"), range(30))] == [*range(30)]


def test_what_ends_a_loop_in_python_comes_before_it_is_said_to_hang_in_c():
    assert BUSY * contract.WALL < workers.HANG


def test_outcomes_come_in_the_order_of_the_items(pool):
    assert list(pool(double, range(20))) == [*range(0, 40, 2)]
    assert list(pool(double, [])) == []


def test_items_are_asked_for_as_they_are_wanted(pool):
    asked = []
    outcomes = pool(double, taken(asked))
    assert next(outcomes) == 0
    assert len(asked) == 2 * AHEAD
    next(outcomes)
    assert len(asked) == 2 * AHEAD + 1


def test_a_process_that_dies_loses_its_run_only_which_is_done_again(pool, tmp_path):
    assert list(pool(partial(die_once, str(tmp_path)), range(8))) == [*range(8)]


def test_an_item_that_ends_every_process_is_told_as_lost(pool):
    assert DEATHS == 3
    assert list(pool(die, [7])) == ["7 was lost: SIGKILL"]


STARTED_BY = 2.0  # seconds; a busy machine takes its time to start a process


def test_an_item_that_takes_for_ever_is_ended(monkeypatch):
    monkeypatch.setattr(workers, "DEATHS", 2)  # it is waited for each time
    with Pool(2, lost=lambda item, death: death.words, patience=STARTED_BY) as pool:
        assert list(pool(hang, range(3))) == [0, "no end in 2 s of real time", 2]


def test_one_that_hangs_in_c_is_ended_by_its_worker_which_says_where(monkeypatch):
    monkeypatch.setattr(workers, "HANG", 0.2)
    with Pool(1, lost=lambda item, death: death) as pool:
        (death,) = pool(hang_in_c, [1])
    line = 2 + hang_in_c.__code__.co_firstlineno
    assert death == ("no end in 0.2 s of real time", f"errands.py:{line}", True)


def test_who_takes_an_outcome_may_have_others_done_before_the_next(pool):
    outcomes = [(one, *pool(double, [one, one])) for one in pool(double, range(6))]
    assert outcomes == [(2 * n, 4 * n, 4 * n) for n in range(6)]


def test_what_a_function_refuses_and_a_bug_come_out_here(pool):
    with pytest.raises(UserError, match="5 cannot be"):
        list(pool(refuse, [5]))
    with pytest.raises(RuntimeError, match="KeyError: 5"):
        list(pool(break_down, [5]))
    assert list(pool(double, [1])) == [2]


def test_a_message_that_breaks_off_is_the_death_of_who_has_sent_it():
    whole = io.BytesIO()
    _send(whole, "a message")
    for length in (0, 5, 8, len(whole.getvalue()) - 1):
        with pytest.raises(EOFError):
            _receive(io.BytesIO(whole.getvalue()[:length]))
    assert _receive(io.BytesIO(whole.getvalue())) == "a message"
