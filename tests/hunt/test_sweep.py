"""Which single fault comes next depends on what came of those before."""

from collections import Counter

from canopen_twins.hunt.contract import Plan
from canopen_twins.hunt.run import Result
from canopen_twins.hunt.sweep import Sweep


def plans(name, count=100):
    return (Plan(({"at": float(n), "inject": name},)) for n in range(count))


def swept(result, count, **sources):
    """How often each comes among so many; `result` tells what its plan comes to."""
    sweep = Sweep([plans(name, length) for name, length in sources.items()])
    seen = Counter()
    for number, plan in zip(range(count), sweep, strict=False):
        (name,) = plan.faults
        seen[name] += 1
        sweep.learn(result(number, name, plan))
    return seen


def test_sources_take_turns():
    sweep = Sweep([plans("one"), plans("other")])
    assert [next(sweep).faults[0] for _ in range(4)] == ["one", "other", "one", "other"]


def test_what_changes_nothing_comes_a_fifth_as_often():
    def result(number, name, plan):
        if name == "idle":
            return Result(plan, trace="always the same")
        return Result(plan, trace=str(number))

    seen = swept(result, 62, idle=100, busy=100)
    assert seen == {"idle": 11, "busy": 51}


def test_what_a_plan_suggests_comes_when_the_others_have_had_their_turn():
    def suggested(result):
        return [plans("more", 2), plans("most", 1)] if result.plan.faults == ("one",) else []

    sweep = Sweep([plans("one", 1), plans("other"), plans("another")], suggested)
    names = []
    for number, plan in zip(range(9), sweep, strict=False):
        names += plan.faults
        sweep.learn(Result(plan, trace=str(number)))
    first, later = ["one", "other", "another"], ["other", "another"]
    assert names == [*first, "more", "most", *later, "more", "other"]


def test_what_stands_in_two_sources_comes_once():
    keys = [plan.key for plan in Sweep([plans("one", 3), plans("one", 5), plans("other", 2)])]
    assert len(keys) == len({*keys}) == 7


def test_none_is_forgotten_and_all_come_to_their_end():
    def result(number, name, plan):
        return Result(plan, trace="same")

    assert swept(result, 1000, short=3, long=7) == {"short": 3, "long": 7}
