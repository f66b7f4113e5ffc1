"""Random sparks: a seeded Poisson process whose rate may depend on the voltage."""

from dataclasses import dataclass, field
from math import ceil, exp, inf
from random import Random

from canopen_twins.devices.charger.model.ticks import NEVER, TICK

HIGHEST = 20.0  # scales above breakdown: it sparks at every tick by then
SIZES = (0.15, 0.5)  # share of the maximum current, drawn evenly; reaches all four levels


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
