"""What a tester sends on and listens to: the segment of a bench, or a bus in real time."""

from abc import ABC, abstractmethod
from collections import deque

from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.live.bus import OpenBus, ReopenedBus, steady

NAME = "tester"


class Bus(ABC):
    """One of the two, with its clock."""

    @property
    @abstractmethod
    def now(self) -> float:
        """Seconds of its clock."""

    @abstractmethod
    def send(self, frame: Frame) -> None:
        """Put a frame on the bus."""

    @abstractmethod
    def receive(self, seconds: float) -> Frame | None:
        """The next frame of others; none if none has come for so long."""


class SimulatedBus(Bus):
    """The clock goes on when somebody waits, and no further than to the next frame."""

    def __init__(self, segment: Segment[Node]) -> None:
        self._segment = segment
        self._wire = segment.master(NAME)
        self._heard: deque[Frame] = deque()
        segment.listeners.append(self._hear)

    @property
    def now(self) -> float:
        """Seconds of the bench."""
        return self._segment.clock.now

    def send(self, frame: Frame) -> None:
        """The answers have come when this returns."""
        self._wire.put(frame)
        self._segment.deliver()

    def receive(self, seconds: float) -> Frame | None:
        """Let time pass until there is one."""
        clock = self._segment.clock
        end = clock.ticks + microseconds(seconds)
        while not self._heard and clock.ticks < end:
            self._segment.advance_to(min(clock.next_tick, end) / MICROSECONDS)
        return self._heard.popleft() if self._heard else None

    def _hear(self, frame: Frame, sender: str) -> None:
        if sender != NAME:
            self._heard.append(frame)


class RealBus(Bus):
    """A bus of python-can, or one on a hub."""

    def __init__(self, open_bus: OpenBus) -> None:
        """Raises `UserError` if the bus cannot be opened."""
        self._bus = ReopenedBus(open_bus)

    @property
    def now(self) -> float:
        """Seconds on the wall, since whenever."""
        return steady()

    def send(self, frame: Frame) -> None:
        """At once."""
        self._bus.transmit(frame, NAME)

    def receive(self, seconds: float) -> Frame | None:
        """Wait for it; what is none, as an error frame, does not end the wait."""
        end = steady() + seconds
        while True:
            frame = self._bus.receive(max(end - steady(), 0.0))
            if frame is not None or steady() >= end:
                return frame

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()
