"""Time in whole ticks of 10 ms: one long step then equals many short ones exactly."""

from dataclasses import dataclass

TICK_MS = 10
TICK = TICK_MS / 1000  # s
NEVER = 1 << 62  # ticks


def whole_ticks(seconds: float) -> int:
    """Raises ValueError where `seconds` is not a whole multiple of 10 ms."""
    ticks = round(seconds / TICK)
    if abs(ticks * TICK - seconds) > 1e-6:
        raise ValueError(f"{seconds} s is not a whole multiple of {TICK} s")
    return ticks


@dataclass
class Hold:
    """A condition that counts only after it has held for some ticks without interruption."""

    delay: int
    _since: int | None = None

    def update(self, now: int, condition: bool) -> None:
        """Note whether it holds at this moment."""
        if not condition:
            self._since = None
        elif self._since is None:
            self._since = now

    def due(self, now: int) -> bool:
        """Whether it has held long enough."""
        return self._since is not None and now - self._since >= self.delay

    def quiet(self, now: int) -> int:
        """Ticks until it is due by itself."""
        if self._since is None or self.due(now):
            return NEVER
        return self.delay - (now - self._since)
