"""What a device has shown in a trace of what its twin lets one set."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from canopen_twins.bus.sdo import Address

MOST = 10_000  # that are kept of a kind


class Sample(NamedTuple):
    """A value that a TPDO has brought, where it is another than before."""

    tick: int
    """Microseconds of the trace."""
    before: int
    """When the PDO had come the time before."""
    value: float


@dataclass
class Shown:
    """Filled by whoever judges; times are in microseconds."""

    answer_times: list[int] = field(default_factory=list)
    """From a request to its answer."""
    store_times: list[int] = field(default_factory=list)
    """The same, of those that store or restore."""
    boot_times: list[int] = field(default_factory=list)
    """From a reset to the boot-up message."""
    beats: list[int] = field(default_factory=list)
    """From one heartbeat to the next."""
    read: dict[Address, tuple[object, object]] = field(default_factory=dict)
    """What the device and the twin have first answered of an object that nobody had written."""
    raw: dict[Address, bytes] = field(default_factory=dict)
    """The same of the device, as it came."""
    measured: dict[Address, list[tuple[float, float]]] = field(default_factory=dict)
    """What device and twin had in a measured object, at the same moments."""
    series: dict[Address, list[Sample]] = field(default_factory=dict)
    """What TPDOs have brought."""
    begun: int = 0
    """When the twin got its power, in the trace."""
    _came: dict[Address, int] = field(default_factory=dict)

    @staticmethod
    def keep(times: list[int], time: int) -> None:
        """One of many."""
        if len(times) < MOST:
            times.append(time)

    def pair(self, address: Address, device: object, twin: object) -> None:
        """A measured value on both sides."""
        pairs = self.measured.setdefault(address, [])
        if isinstance(device, int | float) and isinstance(twin, int | float) and len(pairs) < MOST:
            pairs.append((device, twin))

    def sample(self, address: Address, tick: int, value: object) -> None:
        """A TPDO has brought a value."""
        series = self.series.setdefault(address, [])
        before, self._came[address] = self._came.get(address, tick), tick
        if not isinstance(value, int | float) or len(series) >= MOST:
            return
        if not series or series[-1].value != value:
            series.append(Sample(tick, before, value))
