"""The HEINZMANN CAN between the two units, as two directions that can be disturbed on their own."""

from collections import deque
from dataclasses import dataclass, field

from simulators.devices.gateway.model.parameters import Unit
from simulators.devices.gateway.model.telegrams import Telegram
from simulators.devices.gateway.model.timing import MILLISECOND, Time


@dataclass
class Direction:
    """Telegrams on their way to one unit; they never overtake each other."""

    time: Time
    delay: int = MILLISECOND
    """Microseconds a telegram takes (A-24)."""
    cut: bool = False
    drop: int = 0
    """How many of the next telegrams are lost."""
    _underway: deque[tuple[int, Telegram]] = field(default_factory=deque, init=False)

    def send(self, telegram: Telegram) -> None:
        """Put a telegram on its way, or lose it."""
        if self.cut:
            return
        if self.drop:
            self.drop -= 1
            return
        due = self.time.now + self.delay
        if self._underway:
            due = max(due, self._underway[-1][0])
        self._underway.append((due, telegram))

    @property
    def due(self) -> int | None:
        """When the next telegram arrives; None if none is on its way."""
        return self._underway[0][0] if self._underway else None

    def arrive(self) -> Telegram:
        """Take the next telegram out."""
        return self._underway.popleft()[1]


class Link:
    """Both directions, and the bit rates of the units that are connected."""

    def __init__(self, time: Time) -> None:
        self.to = {unit: Direction(time) for unit in Unit}
        self.bit_rates: dict[Unit, int] = {}
        """Of the units that run, in kBit/s; a unit set by hand to its registers is not in it."""

    @property
    def disturbed(self) -> bool:
        """Whether the units talk at different bit rates, which is a bus error in both (7.2.1)."""
        return len(set(self.bit_rates.values())) > 1
