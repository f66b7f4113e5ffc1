"""Time in whole ticks of 10 ms, so that one long step equals many short ones; hour counters."""

from dataclasses import dataclass
from typing import NamedTuple

TICK_MS = 10
TICK = TICK_MS / 1000  # s
NEVER = 1 << 62  # ticks
MINUTES_A_DAY = 24 * 60
MINUTES_A_YEAR = 365 * MINUTES_A_DAY
LAST_YEAR = 255


def whole_ticks(seconds: float) -> int:
    """Raises ValueError where `seconds` is not a whole multiple of 10 ms."""
    ticks = round(seconds / TICK)
    if abs(ticks * TICK - seconds) > 1e-6:
        raise ValueError(f"{seconds} s is not a whole multiple of {TICK} s")
    return ticks


MINUTE = whole_ticks(60.0)


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


class Duration(NamedTuple):
    """A counter as it is read (2000h); years stop at 255."""

    years: int
    days: int
    hours: int
    minutes: int


def duration(ticks: int) -> Duration:
    """What a counter shows after so many ticks."""
    years, rest = divmod(ticks // MINUTE, MINUTES_A_YEAR)
    days, rest = divmod(rest, MINUTES_A_DAY)
    return Duration(min(years, LAST_YEAR), days, *divmod(rest, 60))


@dataclass
class Hours:
    """The three hour counters in ticks: with supply, with charging, with discharging."""

    operating: int = 0
    charging: int = 0
    discharging: int = 0

    def add(self, ticks: int, charging: bool, discharging: bool) -> None:
        """Time has passed, with or without the two stages on."""
        self.operating += ticks
        self.charging += ticks * charging
        self.discharging += ticks * discharging
