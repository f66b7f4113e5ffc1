"""Measured values as a master gets them: refreshed once a cycle, with noise by seed."""

from collections.abc import Callable, Collection
from functools import partial
from hashlib import blake2b

from canopen.objectdictionary.datatypes import INTEGER_TYPES, SIGNED_TYPES

from canopen_twins.bus.clock import microseconds
from canopen_twins.device.timing import Timing
from canopen_twins.slave.object import Address, Entry, Value
from canopen_twins.slave.slave import Slave

HALF = 1 << 63  # of the numbers that 8 bytes can be


class Measurement:
    """Stands between some entries of a slave and what they show.

    Without a refresh cycle a value is taken when it is read, and has new noise once a cycle of the
    device. Noise depends on address and time alone, so that who looks changes nothing.
    """

    def __init__(
        self, slave: Slave, measured: Collection[Address], timing: Timing, cycle: float
    ) -> None:
        """`measured` may name entries that the dictionary does not have; `cycle` is in seconds."""
        self._clock = slave.clock
        self._cycle = microseconds(timing.measure_time or cycle)
        self._noise = timing.noise
        self._seed = f"{timing.seed} {slave.node_id}"
        self._shown: dict[Address, Value] = {}
        self._taken: dict[Address, Callable[[], Value]] = {}
        for entry in (slave.entry(*address) for address in measured if slave.has(*address)):
            self._stand_before(entry, held=bool(timing.measure_time))
        if timing.measure_time:
            self._refresh()
            slave.clock.every(timing.measure_time, self._refresh)

    def _stand_before(self, entry: Entry, *, held: bool) -> None:
        address = entry.address
        shown = self._shown
        take = self._taken[address] = partial(self._take, entry, entry.source)
        entry.source = (lambda: shown[address]) if held else take

    def _refresh(self) -> None:
        for address, take in self._taken.items():
            self._shown[address] = take()

    def _take(self, entry: Entry, source: Callable[[], Value]) -> Value:
        value = source()
        if not self._noise or not isinstance(value, int | float):
            return value
        number = microseconds(self._clock.now) // self._cycle
        seed = f"{self._seed} {entry.address} {number}"
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
