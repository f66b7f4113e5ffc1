"""The HEINZMANN CAN between the two units, as two directions that can be disturbed on their own."""

from collections import deque
from dataclasses import dataclass, field

from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.telegrams import Telegram
from canopen_twins.devices.gateway.model.timing import MILLISECOND, NEVER, Time


@dataclass
class Direction:
    """Telegrams on their way to one unit; they never overtake each other."""

    time: Time
    delay: int = MILLISECOND
    """Microseconds a telegram takes (A-24)."""
    cut: bool = False
    drop: int = 0
    """How many of the next telegrams are lost."""
    due: int = field(default=NEVER, init=False)
    """When the next telegram arrives, us; NEVER if none is on its way."""
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
        else:
            self.due = due
        self._underway.append((due, telegram))

    def arrive(self) -> Telegram:
        """Take the next telegram out."""
        telegram = self._underway.popleft()[1]
        self.due = self._underway[0][0] if self._underway else NEVER
        return telegram


class Link:
    """Both directions, and whether the units that are connected understand each other."""

    def __init__(self, time: Time) -> None:
        self.to = {unit: Direction(time) for unit in Unit}
        self.disturbed = False
        """Whether the units talk at different bit rates, which is a bus error in both (7.2.1)."""
        self._bit_rates: dict[Unit, int] = {}

    def connect(self, unit: Unit, bit_rate: int) -> None:
        """A unit runs, with so many kBit/s; one set by hand to its registers is left aside."""
        self._bit_rates[unit] = bit_rate
        self._compare()

    def disconnect(self, unit: Unit) -> None:
        """A unit does not run any more."""
        self._bit_rates.pop(unit, None)
        self._compare()

    def _compare(self) -> None:
        self.disturbed = len(set(self._bit_rates.values())) > 1
