"""An expectation at work: from the moment of its step until it is decided."""

from collections import deque
from collections.abc import Callable

from simulators.clock import Clock, microseconds
from simulators.node import Node
from simulators.replay.scenario import Expectation, Step
from simulators.replay.verdict import Finding
from simulators.wire import Frame

GRAIN = 1  # microsecond: a moment of the clock is over when the next one begins
KEPT = 100  # frames, to tell what came instead

Decide = Callable[["Window", Finding, int], None]


class Window:
    """Hears the frames of one node and looks at it; tells `decide` once, with the moment of it."""

    def __init__(
        self, step: Step, expectation: Expectation, node: Node, clock: Clock, decide: Decide
    ) -> None:
        self.step = step
        self.node = node
        self._expectation = expectation
        self._clock = clock
        self._decide = decide
        self._frames: deque[Frame] = deque(maxlen=KEPT)
        self._last = clock.ticks + microseconds(expectation.within)
        self._end_timer = clock.at_tick(self._last + GRAIN, self._end)
        if expectation.looks:
            self._look_timer = clock.at_tick(clock.ticks + GRAIN, self._look)

    def hear(self, frame: Frame) -> None:
        """Take a frame of the node."""
        if self._clock.ticks <= self._last:
            self._frames.append(frame)
            self._conclude(self._expectation.on_frame(frame, self.node), self._clock.ticks)

    def _look(self) -> None:
        finding = self._expectation.on_look(self.node)
        self._look_timer = self._clock.after(self.node.device.cycle, self._look)
        self._conclude(finding, self._clock.ticks - GRAIN)

    def _end(self) -> None:
        self._conclude(self._expectation.at_end(list(self._frames), self.node), self._last)

    def _conclude(self, finding: Finding | None, tick: int) -> None:
        if finding is not None:
            self._end_timer.cancel()
            if self._expectation.looks:
                self._look_timer.cancel()
            self._decide(self, finding, tick)
