"""Watching a plant: which condition has lasted for longer than its delay."""

from collections.abc import Callable, Iterable
from math import ceil
from typing import NamedTuple

from simulators.devices.topcon.model.plant import Plant

Condition = Callable[[Plant], bool]


class Protection(NamedTuple):
    """A condition that becomes an error when it lasts; the error can be reset once it is over."""

    error: int
    condition: Condition
    delay: float = 0.0  # s
    armed: Condition = lambda _: True


class Watch:
    """Counts ticks of `tick` seconds; one without the condition starts the count again."""

    def __init__(self, protections: Iterable[Protection], tick: float) -> None:
        self._protections = tuple(protections)
        self._enough = [max(1, ceil(row.delay / tick - 1e-9)) for row in self._protections]
        self._lasted: dict[int, int] = {}  # ticks, by place in the table

    def step(self, plant: Plant) -> None:
        """Look at the plant, at the end of a tick."""
        self._lasted = {
            place: self._lasted.get(place, 0) + 1
            for place, row in enumerate(self._protections)
            if row.condition(plant) and row.armed(plant)
        }

    @property
    def errors(self) -> list[int]:
        """Error numbers of what has lasted long enough, in the order of the table."""
        lasted = self._lasted.items()
        return [self._protections[at].error for at, ticks in lasted if ticks >= self._enough[at]]

    @property
    def pending(self) -> bool:
        """Whether a condition lasts, but not yet long enough."""
        return any(ticks < self._enough[at] for at, ticks in self._lasted.items())

    def persists(self, error: int, plant: Plant) -> bool:
        """Whether the cause of an error is still there."""
        return any(row.error == error and row.condition(plant) for row in self._protections)
