"""The functions of `time` that look at a clock or wait, on the clock of the bench."""

import time
from collections.abc import Callable

from simulators.simulated_time.baton import TICK, Baton

EPOCH = 946_684_800  # `time.time()` when the bench was made, so that every run has the same dates
NANOSECONDS = 1_000_000_000
MOST_READINGS = 100_000  # of a clock that stands still: a loop that never waits


class Wall:
    """What stands in for the clocks on the wall."""

    def __init__(self, baton: Baton) -> None:
        self._baton = baton
        self._tick = -1
        self._readings = 0

    def now(self) -> float:
        """Seconds of the bench's clock.

        Raises:
            SimulatedTimeError: somebody asks again and again and never waits.
        """
        self._baton.holder()
        tick = self._baton.clock.ticks
        self._readings = self._readings + 1 if tick == self._tick else 1
        self._tick = tick
        if self._readings > MOST_READINGS:
            raise self._baton.refusal(
                "a loop asks for the time and never waits: simulated time passes only while the"
                " master waits, as in time.sleep()"
            )
        return self._baton.clock.now

    def sleep(self, seconds: float) -> None:
        """See `time.sleep`."""
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        self._baton.wait(lambda: False, max(seconds, TICK))  # a loop around sleep(0) goes on

    def date(self) -> float:
        """See `time.time`."""
        return EPOCH + self.now()

    def functions(self) -> dict[str, Callable[..., object]]:
        """The functions of `time` by their names."""
        return {
            "sleep": self.sleep,
            "time": self.date,
            "time_ns": lambda: round(self.date() * NANOSECONDS),
            "monotonic": self.now,
            "monotonic_ns": lambda: round(self.now() * NANOSECONDS),
            "perf_counter": self.now,
            "perf_counter_ns": lambda: round(self.now() * NANOSECONDS),
            "localtime": lambda seconds=None: time.localtime(self._or_now(seconds)),
            "gmtime": lambda seconds=None: time.gmtime(self._or_now(seconds)),
        }

    def _or_now(self, seconds: float | None) -> float:
        return self.date() if seconds is None else seconds
