"""Twins on a python-can bus, in real time, on the calling thread."""

import logging
from collections.abc import Callable

from canopen_twins.bus.clock import microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.live import garbage
from canopen_twins.live.bus import OpenBus, ReopenedBus, steady
from canopen_twins.live.orders import Orders
from canopen_twins.live.port import LONGEST_WAIT

log = logging.getLogger(__name__)

LONGEST_GAP = 1.0  # seconds of real time that are made up for
STALL = 0.2  # seconds of real time of which one is told
AFTER_STALL = {
    False: "periodic messages that are late are sent once",
    True: "periodic messages that are late follow one another",
}


def serve(
    segment: Segment[Node],
    open_bus: OpenBus,
    stopped: Callable[[], bool],
    ready: Callable[[], None] | None = None,
    orders: Orders | None = None,
) -> None:
    """Run the nodes of a segment on a bus until `stopped` says so; it is asked every 20 ms.

    What the nodes have sent before, such as their boot-up, goes out first; `ready` is called after
    that. A bus that fails is opened again and again, while time goes on for the nodes. `orders` of
    other threads are carried out between two frames, 20 ms after they were put at the latest.

    Raises:
        UserError: the bus cannot be opened at the start.
    """
    bus = ReopenedBus(open_bus)
    segment.listeners.append(bus.transmit)
    try:
        segment.deliver()
        if ready is not None:
            ready()
        drive(segment, bus, stopped, orders=orders)
    finally:
        segment.listeners.remove(bus.transmit)
        bus.close()


def drive(
    segment: Segment[Node],
    bus: ReopenedBus,
    stopped: Callable[[], bool],
    wall: Callable[[], float] = steady,
    orders: Orders | None = None,
) -> None:
    """Let a segment keep pace with the seconds of `wall` and hear what comes over a bus.

    The clock goes on by one deadline at a time: a model that is late leaves room for frames. After
    a gap, as of a suspended process, it goes on from where it stood. After a stall that is no such
    gap, time is made up for; periodic messages that are late by more than a period are sent once
    and go on in step, unless the clock `catches_up`.
    """
    orders, stalled = orders or Orders(), False
    clock, advance_to, send = segment.clock, segment.advance_to, segment.send
    reached = passed = clock.now
    origin = wall() - reached
    while not stopped():
        due = clock.next_deadline
        busy = orders.waiting
        left = 0.0 if busy else due - passed
        if 0.0 < left < 2 * LONGEST_WAIT:  # it matters what has passed since the clock was asked
            left = due - wall() + origin
        frame = _received(bus, left)
        passed = wall() - origin
        gap = passed - reached
        if gap > LONGEST_GAP:
            log.warning("%.1f s of real time are left out: suspended, or too slow", gap)
            origin += gap
            passed, gap = reached, 0.0
        if gap > STALL and not stalled:
            log.warning("stood still for %.1f s: %s", gap, AFTER_STALL[clock.catches_up])
        stalled = gap > STALL
        if not clock.catches_up:
            clock.unseen = microseconds(passed)
        reached = min(passed, due)
        advance_to(reached)
        if frame is not None:
            send(frame)
        if busy:
            orders.carry_out()
    advance_to(clock.now)  # what the last frame has set off at once


def _received(bus: ReopenedBus, left: float) -> Frame | None:
    """What comes before something is due; where that is far and nothing comes, nobody waits."""
    if left <= LONGEST_WAIT:
        return bus.receive(max(left, 0.0))
    frame = bus.receive(LONGEST_WAIT)
    if frame is None:
        garbage.search_while_quiet()
    return frame
