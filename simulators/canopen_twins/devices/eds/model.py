"""Values that move by themselves: numbers and seconds, with chance from a seed."""

from abc import abstractmethod
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from math import exp, floor, inf, isclose, log
from random import Random
from typing import NamedTuple

Read = Callable[[], float]
"""A number that may be another one later: of a setting, of another value, of what is written."""
MICROSECONDS = 1_000_000
SHORTEST = 10_000  # microseconds between two changes
HALF = 0.5
NEAR = 1e-6  # of what is aimed at: less is not told from it by 32 bits


def constant(number: float) -> Read:
    """A number that stays."""
    return lambda: number


class Kind(NamedTuple):
    """The numbers there is room for."""

    whole: bool
    low: float = -inf
    high: float = inf


class Quantity:
    """One value; `reading` is what is measured of it, a number of its kind.

    Faults, by their names, let it stand still or falsify the reading. What a step depends on is
    taken by `observe`, so that the order of several quantities does not matter.
    """

    def __init__(self, start: float, kind: Kind) -> None:
        self.value = start
        self.kind = kind
        self.holds: set[str] = set()
        self.replaced: dict[str, float] = {}
        self.offsets: dict[str, float] = {}

    @property
    def reading(self) -> float:
        """What is measured."""
        if self.replaced:
            return self._measured([*self.replaced.values()][-1])
        return self._measured(self.value + sum(self.offsets.values()))

    def _measured(self, value: float) -> float:
        value = min(max(value, self.kind.low), self.kind.high)
        return floor(value + HALF) if self.kind.whole else value

    def put(self, value: float) -> None:
        """Somebody sets it; it moves on from there."""
        self.value = value

    @property
    def rest(self) -> float:
        """Seconds from the last step during which the reading stays, if all others do."""
        return inf

    def observe(self) -> None:
        """Take in what the next step depends on."""

    @abstractmethod
    def step(self, dt: float) -> None:
        """Let `dt` seconds pass."""

    def _until_seen(self, speed: float) -> float:
        """Seconds until the reading changes at a speed per second."""
        if not speed or not self.kind.whole:
            return 0.0 if speed else inf
        beyond = self.value - floor(self.value + HALF)  # of the number it reads as
        return (HALF - beyond if speed > 0 else HALF + beyond) / abs(speed)


class Follower(Quantity):
    """Approaches what it follows as a first-order lag does; at once without a time constant."""

    def __init__(self, start: float, kind: Kind, aim: Read, time_constant: Read) -> None:
        super().__init__(start, kind)
        self.aim = aim
        self._time_constant = time_constant
        self._observed = start

    @property
    def rest(self) -> float:
        """Until another number is nearer; what has no numbers moves until it is there."""
        aim, time_constant = self.aim(), self._time_constant()
        if self.value == aim:
            return inf
        if not self.kind.whole or time_constant <= 0:
            return 0.0
        away = self.value - aim
        border = floor(self.value + HALF) + (HALF if away < 0 else -HALF) - aim
        return time_constant * log(away / border) if away * border > 0 else inf

    def observe(self) -> None:
        """What it follows."""
        self._observed = self.aim()

    def step(self, dt: float) -> None:
        """The exact solution for an aim that stays."""
        aim, time_constant = self._observed, self._time_constant()
        left = exp(-dt / time_constant) if time_constant > 0 else 0.0
        self.value = aim + (self.value - aim) * left
        if isclose(self.value, aim, rel_tol=NEAR, abs_tol=NEAR * NEAR):
            self.value = aim


class Ramp(Quantity):
    """Goes to its target at so much a second."""

    def __init__(self, start: float, kind: Kind, aim: Read, rate: Read) -> None:
        super().__init__(start, kind)
        self.aim = aim
        self._rate = rate
        self._observed = start

    @property
    def rest(self) -> float:
        """It moves until it is there."""
        away, rate = self.aim() - self.value, abs(self._rate())
        if not away or not rate:
            return inf
        return min(self._until_seen(rate if away > 0 else -rate), abs(away) / rate)

    def observe(self) -> None:
        """Where it goes."""
        self._observed = self.aim()

    def step(self, dt: float) -> None:
        """So far, and no further."""
        away, most = self._observed - self.value, abs(self._rate()) * dt
        self.value = self._observed if abs(away) <= most else self.value + most * _sign(away)


class Integral(Quantity):
    """Sums up a speed over time, between two ends."""

    def __init__(self, start: float, kind: Kind, speed: Read, low: Read, high: Read) -> None:
        super().__init__(start, kind)
        self._speed = speed
        self._low = low
        self._high = high
        self._observed = 0.0

    @property
    def rest(self) -> float:
        """It moves as long as there is a speed, and room."""
        speed = self._speed()
        room = self._high() - self.value if speed > 0 else self.value - self._low()
        return self._until_seen(speed) if room > 0 else inf

    def observe(self) -> None:
        """How fast it goes."""
        self._observed = self._speed()

    def step(self, dt: float) -> None:
        """Rectangles, as the speed is one of whole cycles."""
        self.value = min(max(self.value + self._observed * dt, self._low()), self._high())


class Clocked(Quantity):
    """Changes every so many seconds."""

    def __init__(self, start: float, kind: Kind, every: Read) -> None:
        super().__init__(start, kind)
        self._every = every
        self._elapsed = 0  # microseconds since the last change

    @property
    def _period(self) -> int:
        return max(SHORTEST, round(self._every() * MICROSECONDS))

    @property
    def rest(self) -> float:
        """Nothing happens before the next change."""
        return max(0, self._period - self._elapsed) / MICROSECONDS

    def step(self, dt: float) -> None:
        """All changes that are due."""
        times, self._elapsed = divmod(self._elapsed + round(dt * MICROSECONDS), self._period)
        for _ in range(times):
            self.change()

    @abstractmethod
    def change(self) -> None:
        """One change."""


class Counter(Clocked):
    """Adds so much each time; behind the highest number comes the lowest."""

    def __init__(  # noqa: PLR0913, PLR0917 - each is a number of one law
        self, start: float, kind: Kind, every: Read, amount: Read, low: Read, high: Read
    ) -> None:
        super().__init__(start, kind, every)
        self._amount = amount
        self._low = low
        self._high = high

    def change(self) -> None:
        """Count."""
        low = self._low()
        self.value = low + (self.value - low + self._amount()) % (self._high() - low + 1)


class Wanderer(Clocked):
    """Takes a step of chance each time, up or down, and turns back at its ends."""

    def __init__(  # noqa: PLR0913, PLR0917 - likewise
        self, start: float, kind: Kind, every: Read, most: Read, low: Read, high: Read, seed: str
    ) -> None:
        super().__init__(start, kind, every)
        self._most = most
        self._low = low
        self._high = high
        self._chance = Random(seed)

    def change(self) -> None:
        """One step."""
        low, high = self._low(), self._high()
        value = self.value + self._chance.uniform(-1, 1) * self._most()
        value = 2 * high - value if value > high else 2 * low - value if value < low else value
        self.value = min(max(value, low), high)


class Noisy(Clocked):
    """Stays at a value, give or take some noise that is another one each time."""

    def __init__(  # noqa: PLR0913, PLR0917 - likewise
        self, start: float, kind: Kind, every: Read, base: Read, noise: Read, seed: str
    ) -> None:
        super().__init__(start, kind, every)
        self._base = base
        self._noise = noise
        self._chance = Random(seed)
        self._known = base()
        self._around = start

    @property
    def rest(self) -> float:
        """Without noise only its base can change."""
        if self._base() != self._known:
            return 0.0
        return super().rest if self._noise() else inf

    def put(self, value: float) -> None:
        """It stays there from now on."""
        self._around = self.value = value

    def step(self, dt: float) -> None:
        """Another base counts at once, as another setting does."""
        if (base := self._base()) != self._known:
            self._known = self._around = self.value = base
        super().step(dt)

    def change(self) -> None:
        """Other noise."""
        self.value = self._around + self._chance.uniform(-1, 1) * self._noise()


class Sample(NamedTuple):
    """What a value is from a time on."""

    time: float
    """In seconds from power-on."""
    value: float


class Replay(Quantity):
    """Is what samples say; `repeat`: the last one is where it begins anew, otherwise it stays."""

    def __init__(
        self, start: float, kind: Kind, samples: Sequence[Sample], repeat: bool = False
    ) -> None:
        super().__init__(start, kind)
        self._times = [round(sample.time * MICROSECONDS) for sample in samples]
        self._values = [sample.value for sample in samples]
        self._repeat = repeat
        self._elapsed = 0
        self._place = -1  # of the sample that is in force
        self.step(0.0)

    @property
    def rest(self) -> float:
        """Nothing happens before the next sample."""
        if self._place + 1 < len(self._times):
            return (self._times[self._place + 1] - self._elapsed) / MICROSECONDS
        return inf

    def step(self, dt: float) -> None:
        """A sample that comes into force replaces what somebody has put."""
        self._elapsed += round(dt * MICROSECONDS)
        if self._repeat and self._elapsed >= self._times[-1]:
            self._elapsed %= self._times[-1]
            self._place = -1
        place = bisect_right(self._times, self._elapsed) - 1
        if place != self._place:
            self._place = place
            self.value = self._values[place]


def step(quantities: Iterable[Quantity], dt: float) -> None:
    """Let `dt` seconds pass for all that do not stand still."""
    moving = [each for each in quantities if not each.holds]
    for each in moving:
        each.observe()
    for each in moving:
        each.step(dt)


def rest(quantities: Iterable[Quantity]) -> float:
    """Seconds from the last step during which no reading changes."""
    return min((each.rest for each in quantities if not each.holds), default=inf)


def _sign(value: float) -> int:
    return 1 if value > 0 else -1


class Condition(NamedTuple):
    """A reading that is above, below, or exactly a number; all that is given has to hold."""

    reading: Read
    above: Read | None = None
    below: Read | None = None
    equals: Read | None = None

    @property
    def holds(self) -> bool:
        """Whether it is so at this moment."""
        value = self.reading()
        return (
            (self.above is None or value > self.above())
            and (self.below is None or value < self.below())
            and (self.equals is None or value == self.equals())
        )
