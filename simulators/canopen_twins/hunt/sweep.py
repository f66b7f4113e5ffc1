"""Which single fault comes next: kinds that change something come more often than others.

Plans that are much alike stand in one source. All sources take turns; one whose last plan has
changed nothing waits for longer, and what has come of a plan may suggest others. None is forgotten,
and what stands in two of them comes once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from canopen_twins.hunt.contract import Plan
from canopen_twins.hunt.run import Result

NEW, NOTHING = 1.0, 5.0
"""Rounds until the next of a source, by whether the frames of its last plan were those of another.

Cells that are new, and expectations that took more of their time than ever, were tried as well:
mutants are not found sooner with them."""
SUGGESTED = 0.5
"""Rounds until the first of a source that a plan has suggested: before the next of any other."""


class Sweep(Iterator[Plan]):
    """Single faults in an order that depends on what came of those before."""

    def __init__(
        self,
        sources: Sequence[Iterator[Plan]],
        suggested: Callable[[Result], Iterable[Iterator[Plan]]] = lambda result: (),
    ) -> None:
        """`suggested` gives sources that what has come of a plan suggests."""
        self._known: set[str] = set()
        self._suggested = suggested
        self._sources = dict(enumerate(map(self._new, sources)))
        self._due = dict.fromkeys(self._sources, 0.0)
        self._source_of: dict[str, int] = {}
        self._traces: set[str] = set()

    def __next__(self) -> Plan:
        while self._due:
            source = min(self._due, key=lambda source: (self._due[source], source))
            plan = next(self._sources[source], None)
            if plan is not None:
                self._due[source] += NEW  # until it is known better
                self._source_of[plan.key] = source
                return plan
            del self._due[source]
        raise StopIteration

    def _new(self, plans: Iterable[Plan]) -> Iterator[Plan]:
        for plan in plans:
            if plan.key not in self._known:
                self._known.add(plan.key)
                yield plan

    def learn(self, result: Result) -> None:
        """What has come of a plan."""
        source = self._source_of.pop(result.plan.key, None)
        if source in self._due and result.trace in self._traces:
            self._due[source] += NOTHING - NEW
        self._traces.add(result.trace)
        now = min(self._due.values(), default=0.0)
        for plans in self._suggested(result):
            number = len(self._sources)
            self._sources[number] = self._new(plans)
            self._due[number] = now + SUGGESTED
