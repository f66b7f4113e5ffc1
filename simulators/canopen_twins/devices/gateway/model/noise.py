"""Noise of a measurement: another value in every main cycle, and the same for the same seed."""

from dataclasses import dataclass

MULTIPLIER, ADDEND = 6364136223846793005, 1442695040888963407  # Knuth's, of 64 bits
MASK = (1 << 64) - 1


@dataclass(frozen=True)
class Noise:
    """Evenly spread over -`peak`..`peak`, in the unit of the measurement."""

    peak: float
    seed: int
    cycle: int
    """Main cycle, us."""

    def at(self, now: int) -> float:
        """The noise in the main cycle of this moment, in microseconds."""
        if not self.peak:
            return 0.0
        mixed = (self.seed << 32 ^ now // self.cycle) & MASK
        for _ in range(3):
            mixed = (mixed ^ mixed >> 29) * MULTIPLIER + ADDEND & MASK
        return self.peak * ((mixed >> 11) / (1 << 52) - 1)
