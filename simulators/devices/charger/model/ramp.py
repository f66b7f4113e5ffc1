"""The ramp of the charging: every setpoint is reached after the same time, whatever the step."""

from typing import NamedTuple

from simulators.devices.charger.model.ticks import TICK_MS


class Ramp(NamedTuple):
    """A straight line from one reference to another (2002h:11h)."""

    start: float
    end: float
    begin: int  # tick
    time: int  # ms

    def at(self, now: int) -> float:
        """The reference at a tick."""
        if self.done(now):
            return self.end
        return self.start + (self.end - self.start) * (now - self.begin) * TICK_MS / self.time

    def done(self, now: int) -> bool:
        """Whether the end is reached."""
        return (now - self.begin) * TICK_MS >= self.time
