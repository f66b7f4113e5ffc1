"""Measured values as a master gets them: refreshed once a cycle, with noise by seed."""

from collections.abc import Collection
from functools import partial
from hashlib import blake2b
from math import inf

from canopen.objectdictionary.datatypes import INTEGER_TYPES, SIGNED_TYPES

from canopen_twins.bus.clock import microseconds
from canopen_twins.device.timing import Timing
from canopen_twins.slave.object import Address, Entry, Value
from canopen_twins.slave.slave import Slave

HALF = 1 << 63  # of the numbers that 8 bytes can be


class Measurement:
    """Stands between some entries of a slave and what they show.

    Without a refresh cycle a value is taken when it is read, and has new noise once a cycle of the
    device. Noise depends on address and time alone, so that who looks changes nothing. Refreshes
    are made up for when somebody looks: whoever drives the device steps it to each that is `due`.
    """

    def __init__(
        self, slave: Slave, measured: Collection[Address], timing: Timing, cycle: float
    ) -> None:
        """`measured` may name entries that the dictionary does not have; `cycle` is in seconds."""
        self.held = bool(timing.measure_time)
        """Whether what is shown is as it is from one refresh to the next."""
        self._clock = slave.clock
        self._period = microseconds(timing.measure_time or cycle)
        self._noise = timing.noise
        self._seed = f"{timing.seed} {slave.node_id}"
        self._entries = [slave.entry(*address) for address in measured if slave.has(*address)]
        self._sources = [entry.source for entry in self._entries]
        self._taken: list[Value] = []
        self._shown: list[Value] = []
        self._refreshed: float = -inf
        for place, entry in enumerate(self._entries):
            show = partial(self._held_value if self.held else self._fresh, place)
            entry.source = show
        if self.held:
            self.refresh(self._now)
        else:
            self._refreshed = inf

    @property
    def _now(self) -> int:
        return microseconds(self._clock.now)

    @property
    def next_refresh(self) -> float:
        """Microsecond of the refresh after which everything shown is as it is; infinite if it is.

        Noise alone is no reason for another.
        """
        if self._refreshed == inf or self._taken == [take() for take in self._sources]:
            return inf
        return self._refreshed - self._refreshed % self._period + self._period

    def due(self, tick: int) -> int | None:
        """Microsecond of the last refresh up to a moment, if it has yet to be made."""
        last = tick - tick % self._period
        return last if last > self._refreshed else None

    def refresh(self, tick: int) -> None:
        """Show what is measured now, which is at a microsecond of the clock."""
        self._refreshed = tick
        self._taken = [take() for take in self._sources]
        self._shown = [self._with_noise(*each, tick) for each in enumerate(self._taken)]

    def _held_value(self, place: int) -> Value:
        return self._shown[place]

    def _fresh(self, place: int) -> Value:
        return self._with_noise(place, self._sources[place](), self._now)

    def _with_noise(self, place: int, value: Value, tick: int) -> Value:
        if not self._noise or not isinstance(value, int | float):
            return value
        entry = self._entries[place]
        seed = f"{self._seed} {entry.address} {tick // self._period}"
        chance = int.from_bytes(blake2b(seed.encode(), digest_size=8).digest()) / HALF - 1
        return _within(entry, value + self._noise * chance)


def _within(entry: Entry, value: float) -> int | float:
    """What the type of an entry makes of a number: whole, and no less or more than it holds."""
    data_type = entry.variable.data_type
    if data_type not in INTEGER_TYPES or entry.size is None:
        return value
    span = 1 << 8 * entry.size
    low = -span // 2 if data_type in SIGNED_TYPES else 0
    return max(low, min(low + span - 1, round(value)))
