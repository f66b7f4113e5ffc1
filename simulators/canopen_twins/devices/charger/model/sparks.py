"""Sparks: at random in a storm, told by their steepness, counted in four counters (2001h:08h)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from math import ceil, exp, inf
from random import Random

from canopen_twins.devices.charger.model.parameters import Parameter, Parameters
from canopen_twins.devices.charger.model.ticks import NEVER, TICK

WINDOW = 0.008  # s, the 8 of f = Value * Imax / 8 (2002h:16h)
WARNING_SHARE = 0.8  # 2002h:16h and 17h
DEAD_TIME = 20  # ms after a counted spark
FULL = 0xFFFF
TOLERANCE = 1e-9  # "larger than": a change that meets a level exactly is not counted
HIGHEST = 20.0  # scales above breakdown: it sparks at every tick by then
SIZES = (0.15, 0.5)  # share of the maximum current, drawn evenly; reaches all four levels


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
    _blind_until: int = field(default=0, init=False)  # ms

    def level(self, counter: Counter, parameters: Parameters, maximum_current: float) -> float:
        """Steepness in A/s (the manual: mA/ms) above which a counter counts.

        `maximum_current` is that of the type, in A.
        """
        strong = counter in STRONG
        value = parameters[Parameter.STRONG_SPARKS if strong else Parameter.WEAK_SPARKS]
        share = WARNING_SHARE if counter in (STRONG[1], WEAK[1]) else 1.0
        return share * value * self.value.value * maximum_current / WINDOW

    def see(
        self, moment: int, steepness: float, parameters: Parameters, maximum_current: float
    ) -> None:
        """Count a change of the current of so many A/s at a moment in ms, unless it is blind."""
        if moment < self._blind_until:
            return

        def exceeded(counter: Counter) -> bool:
            level = self.level(counter, parameters, maximum_current)
            return steepness > level * (1 + TOLERANCE)

        for group in GROUPS[self.counting]:
            counter = next(filter(exceeded, group), None)
            if counter is not None:
                self._count(counter)
                self._blind_until = moment + DEAD_TIME

    def reset(self, counter: Counter) -> None:
        """Start one counter afresh."""
        self.counts[counter] = 0

    def restart(self) -> None:
        """Start all of them afresh."""
        self.counts = dict.fromkeys(Counter, 0)

    def _count(self, counter: Counter) -> None:
        self.counts[counter] = min(FULL, self.counts[counter] + 1)


@dataclass(frozen=True)
class Storm:
    """How often it sparks: `rate` at the breakdown voltage, e times that per `scale` above it."""

    rate: float  # 1/s
    seed: int = 0
    breakdown: float = 0.0  # V
    scale: float = inf  # V


@dataclass
class RandomSparks:
    """Draws the moments and sizes of the sparks of a storm."""

    storm: Storm
    _random: Random = field(init=False)
    _patience: float = field(init=False)  # expected sparks until the next one
    _spent: float = field(default=0.0, init=False)
    _rate: float = field(default=0.0, init=False)  # 1/s
    _since: int = field(default=0, init=False)  # tick

    def __post_init__(self) -> None:
        self._random = Random(self.storm.seed)
        self._patience = self._random.expovariate(1.0)

    def lead(self, now: int, voltage: float) -> None:
        """From `now` on the output stands at `voltage` (V); 0 ends it all."""
        excess = min(HIGHEST, (voltage - self.storm.breakdown) / self.storm.scale)
        rate = self.storm.rate * exp(excess) if voltage else 0.0
        if rate != self._rate:
            self._spent, self._since, self._rate = self._used(now), now, rate

    def due(self, now: int) -> bool:
        """Whether a spark strikes at this tick."""
        return self._used(now) >= self._patience

    def strike(self, now: int) -> float:
        """The size of the spark that is due, as a share of the maximum current; draws the next."""
        self._spent, self._since = 0.0, now
        self._patience = self._random.expovariate(1.0)
        return self._random.uniform(*SIZES)

    def quiet(self, now: int) -> int:
        """Ticks until the next spark, or a little less."""
        if not self._rate:
            return NEVER
        return max(1, ceil((self._patience - self._used(now)) / (self._rate * TICK)) - 1)

    def _used(self, now: int) -> float:
        return self._spent + self._rate * TICK * (now - self._since)
