"""A bus of python-can that may fail, or that may have somebody on it with one of our node ids."""

import logging
import sys
import time
from collections import deque
from collections.abc import Callable, Container, Iterable
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from threading import Event, Thread

import can
from can.interfaces.udp_multicast import UdpMulticastBus

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import Cob, classify
from canopen_twins.bus.python_can import frame_of, receive
from canopen_twins.errors import UserError
from canopen_twins.live.port import CanSocket, PythonCan, port

log = logging.getLogger(__name__)

if sys.platform == "win32":
    steady = time.perf_counter
else:  # `time.monotonic` of a test may stand still: freezegun takes its place
    steady = partial(time.clock_gettime, time.CLOCK_MONOTONIC)

OpenBus = Callable[[], can.BusABC]
"""Opens a bus; again after it has failed."""

FAILURES = (can.CanError, OSError)
SHORTEST_PAUSE, LONGEST_PAUSE = 0.1, 5.0  # seconds until the next attempt to open the bus
MOST_ECHOES = 256  # own frames that are waited for; older ones have been lost
OWN = (Cob.EMCY, Cob.SDO_ANSWER, Cob.HEARTBEAT)  # what only the node itself sends


class Attempt:
    """Opens a bus in a thread of its own: a hub that is mute keeps nobody waiting."""

    def __init__(self, open_bus: OpenBus) -> None:
        self._open = open_bus
        self._came: SimpleQueue[can.BusABC | BaseException] = SimpleQueue()
        self._given_up = Event()
        Thread(target=self._work, daemon=True).start()

    def result(self, wait: float) -> can.BusABC | None:
        """The bus, none if it is not there within `wait` seconds; raises what opening it raised."""
        try:
            came = self._came.get(timeout=wait)
        except Empty:
            return None
        if isinstance(came, BaseException):
            raise came
        return came

    def give_up(self) -> None:
        """Whatever comes is closed, whenever it comes."""
        self._given_up.set()
        self._discard()

    def _work(self) -> None:
        try:
            self._came.put(self._open())
        except BaseException as failure:
            self._came.put(failure)
        if self._given_up.is_set():
            self._discard()

    def _discard(self) -> None:
        with suppress(Empty, *FAILURES):
            came = self._came.get_nowait()
            if isinstance(came, can.BusABC):
                came.shutdown()


class ReopenedBus:
    """Carries frames between nodes and a bus; they get lost while it fails and is opened again."""

    def __init__(self, open_bus: OpenBus) -> None:
        """Raises `UserError` if the bus cannot be opened."""
        self._open = open_bus
        self._bus: can.BusABC | None = None
        self._port: PythonCan | CanSocket | None = None
        self._echoes: deque[Frame] | None = None  # own frames a bus will bring back, if it does
        self._failing = False
        self._pause = SHORTEST_PAUSE
        self._next_attempt = 0.0
        self._attempt: Attempt | None = None
        try:
            self._connect(open_bus())
        except FAILURES as failure:
            raise UserError(f"the bus cannot be opened: {_words(failure)}") from failure

    def transmit(self, frame: Frame, sender: str) -> None:
        """Send what comes from a node; lost while the bus fails."""
        if self._port is None or not sender:
            return
        if self._echoes is not None:
            self._echoes.append(frame)
        try:
            self._port.send(frame)
        except FAILURES as failure:
            self._fail(failure)
            return
        if self._failing:
            self._recover()

    def receive(self, wait: float) -> Frame | None:
        """The next frame that is not our own, none if there is none within `wait` seconds."""
        if self._port is None:
            self._reopen(wait)
            return None
        try:
            frame = self._port.receive(wait)
        except FAILURES as failure:
            self._fail(failure)
            return None
        if self._echoes is not None and frame is not None and frame in self._echoes:
            self._echoes.remove(frame)
            return None
        return frame

    def close(self) -> None:
        """Leave the bus."""
        if self._attempt is not None:
            self._attempt.give_up()
            self._attempt = None
        if self._bus is not None:
            with suppress(*FAILURES):
                self._bus.shutdown()
        self._bus = self._port = None

    def _connect(self, bus: can.BusABC) -> None:
        self._bus, self._port = bus, port(bus)
        self._echoes = deque(maxlen=MOST_ECHOES) if _echoes(bus) else None

    def _reopen(self, wait: float) -> None:
        left = self._next_attempt - steady()
        if left > 0:
            time.sleep(min(left, wait))
            return
        if self._attempt is None:
            self._attempt = Attempt(self._open)
        try:
            bus = self._attempt.result(wait)
        except FAILURES as failure:
            self._fail(failure)
        else:
            if bus is not None:
                self._attempt = None
                self._connect(bus)

    def _fail(self, failure: Exception) -> None:
        if not self._failing:
            log.error("the bus has failed, trying again until it works: %s", _words(failure))
        else:
            log.info("the bus still fails: %s", _words(failure))
        self.close()
        self._failing = True
        self._next_attempt = steady() + self._pause
        self._pause = min(2 * self._pause, LONGEST_PAUSE)

    def _recover(self) -> None:
        """A frame has been sent: a bus that can be opened, or heard, need not work."""
        log.warning("the bus works again")
        self._failing = False
        self._pause = SHORTEST_PAUSE


def _echoes(bus: can.BusABC) -> bool:
    """Whether a bus gives the sender its own frames back, which nothing marks as such."""
    return isinstance(bus, UdpMulticastBus) or getattr(bus, "receive_own_messages", False)


def _words(failure: Exception) -> str:
    return str(failure) or type(failure).__name__


def with_node_id_check(open_bus: OpenBus, node_ids: Iterable[int], seconds: float) -> OpenBus:
    """The same bus, which is listened to for some seconds when it is opened for the first time.

    Nothing is sent: a question by SDO would end a transfer that a master has under way. Whoever is
    silent for all that time is not found.

    Returns:
        Opens the bus; raises `UserError` if there is such a node.
    """
    wanted = frozenset(node_ids)
    left = [seconds]

    def open_and_listen() -> can.BusABC:
        bus = open_bus()
        if left:
            try:
                _listen(bus, wanted, left.pop())
            except BaseException:
                bus.shutdown()
                raise
        return bus

    return open_and_listen


def _listen(bus: can.BusABC, wanted: Container[int], seconds: float) -> None:
    end = steady() + seconds
    while (left := end - steady()) > 0:
        heard = receive(bus, left)
        if heard is None or heard.is_extended_id or heard.is_remote_frame or heard.is_error_frame:
            continue
        known = classify(heard.arbitration_id)
        if known is not None and known.cob in OWN and known.node_id in wanted:
            sent = frame_of(heard)
            raise UserError(f"node {known.node_id} is on the bus already: it has sent {sent}")
