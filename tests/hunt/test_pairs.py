"""Which pair of faults comes next depends on what came of single ones."""

from itertools import islice
from random import Random

import pytest

from canopen_twins.hunt.contract import Plan
from canopen_twins.hunt.pairs import Pairs
from canopen_twins.hunt.run import Result


def single(name, **moment):
    return Plan(({**moment, "inject": name},))


@pytest.fixture
def pairs():
    return Pairs(Random(1), 100)


def survived(pairs, plan, *, is_new=True):
    pairs.learn(Result(plan), is_new=is_new)


def test_pairs_are_of_faults_that_have_changed_something_and_come_once(pairs):
    assert [*pairs] == []
    for time in (1, 2):
        survived(pairs, single("short", at=time))
        survived(pairs, single("hot", at=time))
    drawn = [*pairs]
    assert {frozenset(plan.faults) for plan in drawn} == {frozenset({"short", "hot"})}
    assert len({plan.key for plan in drawn}) == len(drawn) > 1


def test_one_that_had_nothing_to_strike_is_there_when_another_comes(pairs):
    survived(pairs, single("short", at=1))
    survived(pairs, single("hot", when={"emcy": "any"}))
    survived(pairs, single("emcy_lost", at=5), is_new=False)
    found = [plan.disturbances for plan in pairs if "emcy_lost" in plan.faults]
    assert ({"at": 1, "inject": "emcy_lost"}, {"at": 1, "inject": "short"}) in found
    assert all({**one, "inject": 0} == {**other, "inject": 0} for one, other in found)


def test_some_come_at_one_moment_and_others_as_they_were(pairs):
    survived(pairs, single("short", at=1))
    survived(pairs, single("hot", at=5))
    moments = {tuple(each["at"] for each in plan.disturbances) for plan in pairs}
    assert {(1, 1), (5, 5)} & moments
    assert {(1, 5), (5, 1)} & moments


def test_one_of_another_node_keeps_its_moment_as_a_condition_is_of_its_node(pairs):
    survived(pairs, single("short", when={"emcy": "any"}, node="left"))
    survived(pairs, single("hot", when={"state": "operational"}, node="right"))
    moments = {(each["node"], *each["when"]) for plan in pairs for each in plan.disturbances}
    assert moments == {("left", "emcy"), ("right", "state")}


def test_there_are_no_more_than_were_wanted():
    pairs = Pairs(Random(1), 3)
    for number in range(10):
        survived(pairs, single(f"fault {number}", at=number))
    assert len([*islice(pairs, 10)]) == 3


def test_what_has_failed_already_is_in_no_pair(pairs):
    survived(pairs, single("short", at=1))
    pairs.learn(Result(single("hot", at=1), error="the master has ended"), is_new=True)
    assert [*pairs] == []
