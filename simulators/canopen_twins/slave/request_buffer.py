"""SDO requests of a server that takes its time: one is worked on, others wait for their turn."""

from collections import deque
from collections.abc import Callable

from canopen_twins.bus.clock import Timer, Timing
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import EventLog
from canopen_twins.slave.service import Handler

MOST_WAITING = 32  # where requests wait for each other; one more is lost


class RequestBuffer:
    """Carries a request out and has it answered when its time is over.

    In the time of one request there is room for one more, which the next one overwrites, as in the
    mailbox of a CAN controller; or, with `waits`, for many in the order in which they came.
    """

    def __init__(
        self,
        clock: Timing,
        events: EventLog,
        delay: Callable[[bytes], float],
        on_lost: Callable[[], None] = lambda: None,
        *,
        waits: bool,
    ) -> None:
        """`on_lost`: what a request does that finds no room where many may wait."""
        self._clock = clock
        self._events = events
        self._delay = delay
        self._on_lost = on_lost
        self._waits = waits
        self._waiting: deque[Frame] = deque()
        self._turn: Timer | None = None

    def take(self, frame: Frame, serve: Handler) -> None:
        """Serve a request when its turn has come and its time is over."""
        if self._turn is None:
            self._begin(frame, serve)
        elif not self._waiting or (self._waits and len(self._waiting) < MOST_WAITING):
            self._waiting.append(frame)
        elif self._waits:
            self._events.add_refusal(frame, "lost, too many requests wait already")
            self._on_lost()
        else:
            overwritten, self._waiting[0] = self._waiting[0], frame
            self._events.add_refusal(overwritten, "overwritten by the next request")

    def clear(self) -> None:
        """Forget all of them."""
        self._waiting.clear()
        if self._turn is not None:
            self._turn.cancel()
            self._turn = None

    def _begin(self, frame: Frame, serve: Handler) -> None:
        if delay := self._delay(frame.data):
            self._turn = self._clock.after(delay, lambda: self._end(frame, serve))
        else:
            serve(frame)

    def _end(self, frame: Frame, serve: Handler) -> None:
        self._turn = None
        serve(frame)
        while self._waiting and self._turn is None:
            self._begin(self._waiting.popleft(), serve)
