"""How the nodes of a segment are switched on: so that each of them boots at 0 s."""

from collections.abc import Callable

from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node

GRAIN = 1 / MICROSECONDS


def switch_on(segment: Segment[Node], start: Callable[[], None] | None = None) -> None:
    """Give every node its supply; what has a first step at 0 s, `start`s before they boot.

    Without it they have booted when this returns.
    """
    _boot_until_zero(segment)
    if start is not None:
        start()
    for node in segment.nodes:
        node.power_on()
    if start is None:
        segment.clock.advance_to(segment.clock.now)


def _boot_until_zero(segment: Segment[Node]) -> None:
    """Let power come so long before 0 s that every node boots at 0: there a run begins."""
    clock, boot_times = segment.clock, {}
    for node in segment.nodes:
        if boot_time := microseconds(node.device.timing.boot_time):
            boot_times[node] = boot_time
    if not boot_times:
        return
    clock.ticks -= max(boot_times.values())
    for node, boot_time in boot_times.items():
        clock.at_tick(-boot_time, node.power_on)
    clock.advance_to(-GRAIN)
    clock.ticks = 0  # they boot with the next move of the clock, before the first step
