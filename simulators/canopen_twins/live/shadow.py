"""A twin beside the real device: it hears the same master, sends nothing, and tells differences."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from canopen_twins.bus.clock import microseconds
from canopen_twins.device.device import Device
from canopen_twins.live.bus import OpenBus, ReopenedBus, steady
from canopen_twins.record.compare import Agreement, Comparison, Difference, Tolerances

LONGEST_WAIT = 0.02  # seconds until `stopped` is asked again


def shadow(
    devices: Mapping[str, Device],
    open_bus: OpenBus,
    stopped: Callable[[], bool],
    tell: Callable[[Difference], None],
    tolerances: Tolerances | None = None,
) -> Agreement:
    """Compare what is on a bus with what twins would send, until `stopped` says so.

    The twins are on a bus of their own, in simulated time that keeps pace: there is no way from
    there to the real one. `tell` hears of the first difference of each kind as it happens.

    Raises:
        UserError: the bus cannot be opened, or nothing was heard of one of the devices.
    """
    comparison = Comparison(devices, tolerances)
    comparison.agreement.on_new = tell
    bus = ReopenedBus(open_bus)
    begun = steady()
    try:
        while not stopped():
            frame = bus.receive(LONGEST_WAIT)
            now = microseconds(steady() - begun)
            if frame is None:
                comparison.pass_time(now)
            else:
                comparison.hear(now, frame)
    finally:
        bus.close()
    return comparison.end()
