"""A CAN segment: nodes on one bus and one clock, and whoever listens to their frames."""

from collections import deque
from collections.abc import Callable
from typing import Generic, NamedTuple, Protocol, TypeVar

from simulators.arbitration import Arbitration
from simulators.clock import Clock
from simulators.frame import Frame
from simulators.wire import Outbox, Wire

Listener = Callable[[Frame, str], None]
"""Called with a frame and the name of who sent it, empty for one from outside."""


class Record(NamedTuple):
    """One frame on a segment."""

    time: float
    """Seconds of the segment's clock."""
    frame: Frame
    sender: str
    """The name of the node or master that sent it; empty for one from outside."""

    def __str__(self) -> str:
        """As `candump -L` writes it, with the time of the segment."""
        return f"({self.time:017.6f}) can0 {self.frame}"


class End(Protocol):
    """Who is on a segment: it sends by its wire, and hears what the others send."""

    wire: Wire

    def receive(self, frame: Frame) -> None:
        """Take a frame from the bus; what the end sends is in the outbox afterwards."""


AnyEnd = TypeVar("AnyEnd", bound=End)


class Segment(Generic[AnyEnd]):
    """What one node sends, all others and every listener get, in the order in which it was sent."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.nodes: list[AnyEnd] = []
        self.listeners: list[Listener] = []
        self.outbox: Outbox = deque()
        self._foreign = Wire(self.clock, self.outbox)
        self._touched: list[Callable[[], None]] = []
        self._bus: Arbitration | None = None

    def limit(self, bit_rate: int) -> None:
        """Let frames take their time from now on, at so many bit/s; else they take none."""
        self._bus = Arbitration(self.clock, bit_rate)

    @property
    def limited(self) -> bool:
        """Whether frames take their time."""
        return self._bus is not None

    def master(self, name: str) -> Wire:
        """An end of the bus for somebody who is no node: `put` frames there, then `deliver`.

        Unlike frames from outside, theirs carry a name: whoever brings the segment to a real bus
        takes them along.
        """
        return Wire(self.clock, self.outbox, name)

    def touch(self, see_to: Callable[[], None]) -> None:
        """Somebody holds a device of a node in his hands: see to it before anything else."""
        self._touched.append(see_to)

    def _see_to_touched(self) -> None:
        while self._touched:
            self._touched.pop()()
            self.deliver()

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus that comes from outside; the answers are out after."""
        if self._touched:
            self._see_to_touched()
        self.outbox.append((self._foreign, frame))
        self.deliver()

    def deliver(self) -> None:
        """Bring every frame that is waiting to whoever hears it.

        Listeners come after the nodes, as they may send in turn: no node hears the reply to a
        frame before the frame. They hear the frame that brings a bug to light, too.
        """
        arrived = self.outbox if self._bus is None else self._bus.arrived
        while arrived:
            sender, frame = arrived.popleft()
            try:
                for node in self.nodes:
                    if node.wire is not sender:
                        node.receive(frame)
            finally:
                for listener in self.listeners:
                    listener(frame, sender.name)
        if self._bus is not None:
            self._bus.take(self.outbox)

    def advance(self, seconds: float) -> None:
        """Let time pass; frames are delivered at the moment they are sent."""
        self.advance_to(self.clock.now + seconds)

    def advance_to(self, time: float) -> None:
        """Let time pass up to a moment."""
        if self._touched:
            self._see_to_touched()
        self.clock.advance_to(time, self.deliver)
