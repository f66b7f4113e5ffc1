"""The free search: Hypothesis draws plans, guided to what has not been seen, in batches.

A batch depends on its seed and on what it is given alone. What is known when it begins is frozen,
as Hypothesis wants the score of a plan to depend on nothing but the plan.
"""

from __future__ import annotations

import io
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, ClassVar

from hypothesis import HealthCheck, Phase, given, seed, settings, target
from hypothesis import strategies as st

from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.events import Events
from canopen_twins.hunt.run import Cell, Failure, Result, run
from canopen_twins.hunt.space import Option, Space

RUNS = 40
"""Of a batch: what it learns is of use to the next one."""
SLOTS = 3


@dataclass(frozen=True)
class Batch:
    """What a batch is given."""

    contract: Contract
    events: Events
    seed: int
    known: frozenset[Failure]
    """What is not looked for any more."""
    seen: frozenset[Cell]
    """Where something has gone wrong already."""
    runs: int = RUNS
    """At most."""
    until: float | None = None
    """When it has to be over, as `time.time()`."""
    place: Path | None = None
    """A folder in which the plan that is played lies, in case it ends the process."""
    resumes: ClassVar[bool] = True


class Enough(BaseException):
    """Ends a batch at once; Hypothesis lets it pass."""


def search(batch: Batch) -> list[Result]:
    """Play a batch; every run of it."""
    space = Space(batch.contract.scenario(Plan()), batch.events)
    played: dict[str, Result] = {}
    deadly = {plan.key for plan in suspects(batch.place)}

    def judge(plan: Plan) -> None:
        if plan.key in played or plan.key in deadly:
            return
        if len(played) >= batch.runs or (batch.until is not None and time.time() >= batch.until):
            raise Enough
        with _noted(batch.place, plan):
            result = played[plan.key] = run(batch.contract, plan)
        target(float(len(set(result.cells) - batch.seen)), label="cells")

    test: Callable[..., Any] = given(plan=plans(space))(judge)
    test = seed(batch.seed)(_settings(test))
    told = io.StringIO()  # it tells of seeds
    with redirect_stdout(told), redirect_stderr(told), suppress(Enough):
        test()
    return [*played.values()]


def suspects(place: Path | None) -> Sequence[Plan]:
    """The plans of a batch that were not over when its processes ended."""
    if place is None or not place.is_dir():
        return []
    return [pickle.loads(file.read_bytes()) for file in sorted(place.iterdir())]


@contextmanager
def _noted(place: Path | None, plan: Plan) -> Iterator[None]:
    """It lies there until it is over."""
    if place is None:
        yield
        return
    place.mkdir(exist_ok=True)
    file = next(path for path in (place / str(n) for n in count()) if not path.exists())
    file.write_bytes(pickle.dumps(plan))
    yield
    file.unlink()


_settings = settings(
    max_examples=4 * RUNS,
    deadline=None,
    database=None,
    phases=(Phase.generate, Phase.target),
    suppress_health_check=list(HealthCheck),
)


def plans(space: Space) -> st.SearchStrategy[Plan]:
    """Up to three things that go wrong, each absent or simple if nobody cares."""
    slots = [_slot(space)]
    slots += [st.none() | _slot(space) for _ in range(1, min(space.limits.most, SLOTS))]
    slots += [st.none()] * (SLOTS - len(slots))
    deliveries = st.none() | st.sampled_from(space.deliveries) if space.deliveries else st.none()
    heals = st.just(True) if space.limits.heals else st.booleans().map(lambda leave: not leave)
    orders = st.just(()) | st.sampled_from(space.orders) if space.orders else st.just(())
    arbitrations = st.just("") | st.sampled_from(space.arbitrations)
    return st.builds(_plan, st.tuples(*slots), deliveries, heals, orders, arbitrations)


def _plan(
    slots: tuple[Any, ...],
    delivery: tuple[str, str, Any] | None,
    heals: bool,
    order: tuple[str, ...],
    arbitration: str,
) -> Plan:
    wrong = tuple(each for each in slots if each is not None)
    return Plan(
        wrong, () if delivery is None else (delivery,), heals, order=order, arbitration=arbitration
    )


def _slot(space: Space) -> st.SearchStrategy[Any]:
    found: list[st.SearchStrategy[Any]] = []
    if space.options:
        found.append(st.sampled_from(space.options).flatmap(lambda each: _fault(space, each)))
    if space.changes:
        found.append(st.sampled_from(space.changes).flatmap(lambda each: _change(space, *each)))
    return st.one_of(found) if found else st.none()


def _fault(space: Space, option: Option) -> st.SearchStrategy[Any]:
    return st.builds(
        option.at,
        st.sampled_from(space.moments[option.node]),
        st.sampled_from([*option.parameters, *option.aims, *space.delayed(option)]),
        st.sampled_from(option.lengths),
    )


def _change(space: Space, node: str, key: str, value: object) -> st.SearchStrategy[Any]:
    moments = st.sampled_from(space.moments[node])
    return moments.map(lambda moment: space.change(moment, node, key, value))
