"""Which of the frames or accesses that fit are struck: counted, or by seeded chance."""

from collections.abc import Mapping
from random import Random

from simulators.faults import Parameter

AIM: Mapping[str, Parameter] = {
    "nth": Parameter("the first one that is struck, counted from 1", 1, int, low=1),
    "times": Parameter("how many are struck before it heals by itself; 0: no end", 0, int, low=0),
    "probability": Parameter("the chance of each to be struck, 0..1", 1.0, low=0, high=1),
    "burst": Parameter("how many in a row are struck once chance has it", 1, int, low=1),
    "seed": Parameter("where chance begins: the same seed, the same frames", 1, int),
}
"""The parameters that every fault has whose victims come one after the other."""


class Turn:
    """Is asked once for each that fits."""

    def __init__(
        self,
        nth: int = 1,
        times: int = 0,
        probability: float = 1.0,
        burst: int = 1,
        seed: int = 1,
    ) -> None:
        self._before = nth - 1
        self._times = times
        self._probability = probability
        self._burst = burst
        self._chance = Random(seed)
        self._struck = 0
        self._in_a_row = 0

    @property
    def over(self) -> bool:
        """Whether nothing is struck any more."""
        return 0 < self._times <= self._struck

    def strikes(self) -> bool:
        """Whether the one that has come is struck."""
        if self._before or self.over:
            self._before = max(self._before - 1, 0)
            return False
        if not self._in_a_row and self._chance.random() < self._probability:
            self._in_a_row = self._burst
        if not self._in_a_row:
            return False
        self._in_a_row -= 1
        self._struck += 1
        return True
