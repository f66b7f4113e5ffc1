"""Time of the model: whole microseconds, on a grid that both main cycles meet."""

from dataclasses import dataclass

GRID = 125  # us: 15.625 ms and 16 ms have no greater divisor
MILLISECOND = 1000  # us
GATEWAY_CYCLE = 16 * MILLISECOND  # us, main cycle (7.2.3)
NEVER = 1 << 62  # us: when something is due that is not to come
MOST_CYCLES, MOST_HEARTBEAT_CYCLES = 255, 4095  # of the governor (4.1.2), the gateway (7.2.3)


@dataclass
class Time:
    """The moment, in microseconds, that every part of one system shares."""

    now: int = 0


@dataclass
class Watch:
    """Misses what should come again and again: an RPDO, the heartbeat of a partner."""

    limit: int
    """Main cycles without it after which it is missed; 0: it is not watched."""
    arrived: bool = False
    """Whether it has come since Operational was entered."""
    tripped: bool = False
    """Whether it is missed; over as soon as it comes."""
    _age: int = 0

    def begin(self) -> None:
        """Operational was entered: nothing counts that came before."""
        self.arrived, self.tripped, self._age = False, False, 0

    def receive(self) -> None:
        """It has come."""
        self.arrived, self.tripped, self._age = True, False, 0

    @property
    def patience(self) -> int:
        """Main cycles without it until it is missed; NEVER if it is already, or not watched."""
        return NEVER if self.tripped or not self.limit else self.limit - self._age + 1

    def leap(self, cycles: int) -> None:
        """So many main cycles without it, fewer than `patience`."""
        self._age += cycles

    def step(self) -> None:
        """One main cycle without it."""
        self._age += 1
        self.tripped = self.tripped or 0 < self.limit < self._age


def microseconds(seconds: float) -> int:
    """The same time in microseconds.

    Raises:
        ValueError: negative, or no multiple of 125 us.
    """
    whole = round(seconds * 1_000_000)
    if whole < 0 or whole % GRID:
        raise ValueError(f"{seconds} s is not a multiple of {GRID} us")
    return whole


def cycles(milliseconds: int, cycle: int, most: int) -> int:
    """How many main cycles a time of DcDesk comes to; 0 switches off and stays 0 (7.1.3, 7.2.3).

    Between the printed ranges lie 15 ms and what exceeds the last: one cycle and `most` (A-05).
    """
    if milliseconds == 0:
        return 0
    return min(max(1, milliseconds * MILLISECOND // cycle), most)


def heartbeat_cycles(milliseconds: int) -> int:
    """How many main cycles of the gateway a period or a limit comes to (7.2.3)."""
    return cycles(milliseconds, GATEWAY_CYCLE, MOST_HEARTBEAT_CYCLES)
