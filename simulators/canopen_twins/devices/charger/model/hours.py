"""The three hour counters; they survive everything, and a year has 365 days (A-17)."""

from dataclasses import dataclass
from typing import NamedTuple

from canopen_twins.devices.charger.model.ticks import whole_ticks

MINUTE = whole_ticks(60.0)
MINUTES_A_DAY = 24 * 60
MINUTES_A_YEAR = 365 * MINUTES_A_DAY
LAST_YEAR = 255


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
    """Ticks with supply, with charging and with discharging; set them to continue a former life."""

    operating: int = 0
    charging: int = 0
    discharging: int = 0

    def add(self, ticks: int, charging: bool, discharging: bool) -> None:
        """Time has passed, with or without the two stages on."""
        self.operating += ticks
        self.charging += ticks * charging
        self.discharging += ticks * discharging

    def quiet(self, charging: bool, discharging: bool) -> int:
        """Ticks until the next whole minute of one that runs."""
        running = [self.operating]
        running += [self.charging] * charging + [self.discharging] * discharging
        return min(MINUTE - ticks % MINUTE for ticks in running)
