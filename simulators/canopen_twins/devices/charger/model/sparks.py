"""Sparks: told by the steepness of the current, counted in four counters (2001h:08h to 0Bh)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum

from canopen_twins.devices.charger.model.parameters import Parameter, Parameters

WINDOW = 0.008  # s, the 8 of f = Value * Imax / 8 (2002h:16h)
WARNING_SHARE = 0.8  # 2002h:16h and 17h
DEAD_TIME = 2  # ticks after a counted spark (assumed)
FULL = 0xFFFF
TOLERANCE = 1e-9  # "larger than": a change that meets a level exactly is not counted


class Counter(IntEnum):
    """The four counters, from the highest level to the lowest of the factory settings."""

    STRONG_ERROR = 0x08
    STRONG_WARNING = 0x09
    WEAK_ERROR = 0x0A
    WEAK_WARNING = 0x0B


# The order in which one spark is offered to the counters.
STRONG = (Counter.STRONG_ERROR, Counter.STRONG_WARNING)
WEAK = (Counter.WEAK_ERROR, Counter.WEAK_WARNING)
EXCLUSIVE = (*STRONG, *WEAK)


class Counting(Enum):
    """How many counters one spark may raise (A-57)."""

    EXCLUSIVE = "exclusive"
    PER_CLASS = "per_class"
    CUMULATIVE = "cumulative"


GROUPS: Mapping[Counting, Sequence[Sequence[Counter]]] = {
    Counting.EXCLUSIVE: (EXCLUSIVE,),
    Counting.PER_CLASS: (STRONG, WEAK),
    Counting.CUMULATIVE: tuple((counter,) for counter in EXCLUSIVE),
}


class SparkValue(Enum):
    """What the Value of the formula is: the percentage, or its bare number (A-56)."""

    PERCENT = 0.01
    NUMBER = 1.0


@dataclass
class Sparks:
    """The detector and its counters."""

    counting: Counting = Counting.EXCLUSIVE
    value: SparkValue = SparkValue.PERCENT
    counts: dict[Counter, int] = field(default_factory=lambda: dict.fromkeys(Counter, 0))
    _blind_until: int = field(default=0, init=False)  # tick

    def level(self, counter: Counter, parameters: Parameters, maximum_current: float) -> float:
        """Steepness in A/s (the manual: mA/ms) above which a counter counts.

        `maximum_current` is that of the type, in A.
        """
        strong = counter in STRONG
        value = parameters[Parameter.STRONG_SPARKS if strong else Parameter.WEAK_SPARKS]
        share = WARNING_SHARE if counter in (STRONG[1], WEAK[1]) else 1.0
        return share * value * self.value.value * maximum_current / WINDOW

    def see(
        self, now: int, steepness: float, parameters: Parameters, maximum_current: float
    ) -> None:
        """Count a change of the current of so many A/s, unless the last spark was just now."""
        if now < self._blind_until:
            return

        def exceeded(counter: Counter) -> bool:
            level = self.level(counter, parameters, maximum_current)
            return steepness > level * (1 + TOLERANCE)

        for group in GROUPS[self.counting]:
            counter = next(filter(exceeded, group), None)
            if counter is not None:
                self._count(counter)
                self._blind_until = now + DEAD_TIME

    def reset(self, counter: Counter) -> None:
        """Start one counter afresh."""
        self.counts[counter] = 0

    def restart(self) -> None:
        """Start all of them afresh."""
        self.counts = dict.fromkeys(Counter, 0)

    def _count(self, counter: Counter) -> None:
        self.counts[counter] = min(FULL, self.counts[counter] + 1)
