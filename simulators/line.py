"""A python-can bus that may fail: it is opened again and again, and frames get lost meanwhile."""

import logging
import time
from collections.abc import Callable
from contextlib import suppress

import can

from simulators.errors import UserError
from simulators.wire import Frame

log = logging.getLogger(__name__)

OpenBus = Callable[[], can.BusABC]

FAILURES = (can.CanError, OSError)
SHORTEST_PAUSE, LONGEST_PAUSE = 0.1, 5.0  # seconds until the next attempt to open the bus
ECHO_TIME = 1.0  # seconds within which an own frame may come back
ECHO_ROOM = 1000


class Line:
    """What the nodes of a segment send and hear through the bus."""

    def __init__(self, open_bus: OpenBus) -> None:
        """Raises `UserError` if the bus cannot be opened."""
        try:
            self._bus: can.BusABC | None = open_bus()
        except FAILURES as failure:
            raise UserError(f"the bus cannot be opened: {_words(failure)}") from failure
        self._open = open_bus
        self._echoes = Echoes()
        self._failing = False
        self._pause = SHORTEST_PAUSE
        self._next_attempt = 0.0

    def transmit(self, frame: Frame, sender: str) -> None:
        """Send what comes from a node; lost while the bus fails."""
        if self._bus is None or not sender:
            return
        message = can.Message(
            arbitration_id=frame.can_id,
            is_extended_id=frame.extended,
            is_remote_frame=frame.remote,
            data=Data(frame.data),
        )
        try:
            self._bus.send(message)
        except FAILURES as failure:
            self._fail(failure)
            return
        self._echoes.expect(frame)
        if self._failing:
            self._recover()

    def receive(self, wait: float) -> Frame | None:
        """The next frame that is not our own, none if there is none within `wait` seconds."""
        if self._bus is None:
            self._reopen(wait)
            return None
        try:
            message = self._bus.recv(wait)
        except FAILURES as failure:
            self._fail(failure)
            return None
        if message is None or message.is_error_frame or message.is_fd:
            return None
        if self._failing:
            self._recover()
        extended, remote = message.is_extended_id, message.is_remote_frame
        frame = Frame(message.arbitration_id, bytes(message.data), remote, extended)
        return None if frame in self._echoes else frame

    def close(self) -> None:
        """Leave the bus."""
        if self._bus is not None:
            with suppress(*FAILURES):
                self._bus.shutdown()
        self._bus = None

    def _reopen(self, wait: float) -> None:
        left = self._next_attempt - time.monotonic()
        if left > 0:
            time.sleep(min(left, wait))
            return
        try:
            self._bus = self._open()
        except FAILURES as failure:
            self._fail(failure)

    def _fail(self, failure: Exception) -> None:
        if not self._failing:
            log.error("the bus has failed, trying again until it works: %s", _words(failure))
        else:
            log.info("the bus still fails: %s", _words(failure))
        self.close()
        self._failing = True
        self._next_attempt = time.monotonic() + self._pause
        self._pause = min(2 * self._pause, LONGEST_PAUSE)

    def _recover(self) -> None:
        """A bus that can be opened does not work yet: a frame went over it."""
        log.warning("the bus works again")
        self._failing = False
        self._pause = SHORTEST_PAUSE


class Data(bytearray):
    """The data of a message, copied in one go: python-can's virtual bus copies every message."""

    def __deepcopy__(self, memo: object) -> bytearray:
        return bytearray(self)


class Echoes:
    """Own frames that the bus gives back, as UDP multicast does with every one.

    Nothing marks them; but an identifier has one producer on a CAN bus, so that a frame just like
    one we have sent a moment ago is that one.
    """

    def __init__(self) -> None:
        self._sent: dict[Frame, float] = {}
        self._limit = ECHO_ROOM

    def expect(self, frame: Frame) -> None:
        """A frame has been sent."""
        self._sent[frame] = now = time.monotonic()
        if len(self._sent) > self._limit:
            self._sent = {sent: at for sent, at in self._sent.items() if now - at < ECHO_TIME}
            self._limit = 2 * len(self._sent) + ECHO_ROOM

    def __contains__(self, frame: Frame) -> bool:
        at = self._sent.get(frame)
        return at is not None and time.monotonic() - at < ECHO_TIME


def _words(failure: Exception) -> str:
    return str(failure) or type(failure).__name__
