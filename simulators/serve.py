"""Twins on a python-can bus, in real time, on the calling thread."""

import logging
import time
from collections.abc import Callable

from simulators.clock import Clock
from simulators.line import Line, OpenBus
from simulators.segment import Segment

log = logging.getLogger(__name__)

LONGEST_WAIT = 0.02  # seconds until `stopped` is asked again
LONGEST_GAP = 1.0  # seconds of real time that are made up for


def serve(
    segment: Segment,
    open_bus: OpenBus,
    stopped: Callable[[], bool],
    ready: Callable[[], None] | None = None,
) -> None:
    """Run the nodes of a segment on a bus until `stopped` says so; it is asked every 20 ms.

    What the nodes have sent before, such as their boot-up, goes out first; `ready` is called after
    that. A bus that fails is opened again and again, while time goes on for the nodes.

    Raises:
        UserError: the bus cannot be opened at the start.
    """
    line = Line(open_bus)
    segment.listeners.append(line.transmit)
    try:
        segment.deliver()
        if ready is not None:
            ready()
        pace = Pace(segment.clock)
        while not stopped():
            frame = line.receive(pace.wait())
            segment.advance_to(pace.follow())
            if frame is not None:
                segment.send(frame)
    finally:
        segment.listeners.remove(line.transmit)
        line.close()


class Pace:
    """How far a clock may go: real time sets the pace. Times are in seconds of the clock."""

    def __init__(self, clock: Clock, wall: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._wall = wall
        self._origin = wall() - clock.now
        self._reached = clock.now
        self._due = 0.0

    def wait(self) -> float:
        """Seconds until the clock has something to do, 0.02 at most."""
        self._due = due = self._clock.next_deadline
        left = due - self._wall() + self._origin
        return LONGEST_WAIT if left > LONGEST_WAIT else max(left, 0.0)

    def follow(self) -> float:
        """The time the clock may go to now, never beyond what is due."""
        now = self._wall() - self._origin
        if now - self._reached > LONGEST_GAP:
            gap = now - self._reached
            log.warning("%.1f s of real time are left out: suspended, or too slow", gap)
            self._origin += now - self._reached
            now = self._reached
        self._reached = now = min(now, self._due)
        return now
