"""A bus whose frames take their time: one after the other, the lowest identifier first."""

from collections.abc import Callable, Sequence
from heapq import heappop, heappush
from itertools import count
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame, length
from canopen_twins.bus.wire import Outbox, Wire

FEW = 4  # nodes: among them nobody has to be looked for


class Arbitration:
    """Frames that wait compete for the bus each time it is free; equals keep their order.

    What is over is in `arrived`, with who sent it; the bit rate is in bit/s.
    """

    def __init__(self, clock: Clock, bit_rate: int) -> None:
        self.bit_rate = bit_rate
        self._clock = clock
        self.arrived = Outbox()
        self._waiting: list[tuple[tuple[int, ...], int, Wire, Frame]] = []
        self._order = count()
        self._busy = False

    def take(self, outbox: Outbox, first: str | None = None) -> None:
        """Let everything compete that has been sent by now; a free bus is given to the `first`."""
        while outbox:
            sender, frame = outbox.popleft()
            if sender.name == first and not self._busy:
                self._send(sender, frame)
                continue
            heappush(self._waiting, (priority(frame), next(self._order), sender, frame))
        if self._waiting and not self._busy:
            self._begin()

    def _begin(self) -> None:
        _, _, sender, frame = heappop(self._waiting)
        self._send(sender, frame)

    def _send(self, sender: Wire, frame: Frame) -> None:
        self._busy = True
        self._clock.after(length(frame) / self.bit_rate, lambda: self._end(sender, frame))

    def _end(self, sender: Wire, frame: Frame) -> None:
        self._busy = False
        self.arrived.append((sender, frame))


def priority(frame: Frame) -> tuple[int, ...]:
    """The bits of the arbitration field in their order; the lower one wins (ISO 11898-1)."""
    if frame.extended:
        return (frame.can_id >> 18, 1, 1, frame.can_id & 0x3FFFF, frame.remote)
    return (frame.can_id, frame.remote, 0)


Listener = Callable[[Frame, str], None]
"""Called with a frame and the name of who sent it, empty for one from outside."""

OrderListener = Callable[[str, str, Sequence[Any]], None]
"""Called before something is done to a node: with its name, the order and what goes with it."""


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
    """What one node sends, all others and every listener get, in the order in which it was sent.

    A frame is heard by the nodes, then by `listeners`, each in the order in which they came, and at
    last by `masters`, who may send while they hear: nobody hears a reply before what it replies to.
    """

    def __init__(self) -> None:
        self.clock = Clock()
        self.bit_rate: int | None = None
        """In bit/s; who has another one neither hears nor is heard. None: nobody looks."""
        self.first: str | None = None
        """Who is on the bus first where several send at one microsecond, by its name; then the
        lowest identifier wins, as from the beginning if it is empty. None: as they were sent."""
        self.nodes: list[AnyEnd] = []
        self.listeners: list[Listener] = []
        self.masters: list[Listener] = []
        self.order_listeners: list[OrderListener] = []
        self.outbox = Outbox()
        self._indexed = 0  # how many nodes there were when it was looked who hears what
        self._foreign = Wire(self.clock, self.outbox)
        self._used = -1  # the microsecond of the last frame
        self._touched: list[Callable[[], None]] = []
        self._bus: Arbitration | None = None

    def limit(self, bit_rate: int) -> None:
        """Let frames take their time from now on, at so many bit/s; else they take none."""
        self.bit_rate = bit_rate
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

        Listeners hear the frame that brings a bug to light, too.
        """
        if self.first is not None and self.clock.next_tick <= self.clock.ticks:
            return  # somebody may still send at this microsecond
        arrived = self.outbox if self._bus is None else self._bus.arrived
        while arrived:
            sender, frame = arrived.popleft() if self.first is None else self._winner(arrived)
            nodes = self.nodes
            if self.bit_rate is not None:
                if not self._fits(sender, frame):
                    continue
                nodes = self._hearing(sender, frame)
            elif len(nodes) > FEW:
                nodes = self._hearers(frame)
            try:
                key = frame.can_id, frame.remote
                for node in nodes:
                    if node.wire is not sender and node.wire.hears(key):
                        node.receive(frame)
            finally:
                for listener in self.listeners:
                    listener(frame, sender.name)
                for master in self.masters:
                    master(frame, sender.name)
        if self._bus is not None:
            sent = [each for each in self.outbox if self._fits(*each)]
            self.outbox.clear()
            self._bus.take(Outbox(sent), self.first)

    def _winner(self, arrived: Outbox) -> tuple[Wire, Frame]:
        """Of what waits: the oldest of each sender competes, as controllers keep their order."""
        if self._bus is not None:  # they have competed already
            return arrived.popleft()
        heads: dict[int, int] = {}
        for place, (sender, _) in enumerate(arrived):
            heads.setdefault(id(sender), place)
        is_free, self._used = self._used != self.clock.ticks, self.clock.ticks
        early = [place for place in heads.values() if arrived[place][0].name == self.first]
        competing = early if is_free and early else heads.values()
        place = min(competing, key=lambda place: priority(arrived[place][1]))
        won = arrived[place]
        del arrived[place]
        return won

    def _hearers(self, frame: Frame) -> list[AnyEnd]:
        """Of many nodes those that hear a frame: most are for one of them, or for none."""
        known, key = self.outbox.hearers, (frame.can_id, frame.remote)
        if len(self.nodes) != self._indexed:
            known.clear()
            self._indexed = len(self.nodes)
        nodes = known.get(key)
        if nodes is None:
            nodes = [node for node in self.nodes if node.wire.hears(key)]
            if not frame.extended:  # of those there is an end
                known[key] = nodes
        return nodes

    def _hearing(self, sender: Wire, frame: Frame) -> list[AnyEnd]:
        others = [node for node in self.nodes if node.wire is not sender]
        return [node for node in others if self._fits(node.wire, frame)]

    def _fits(self, wire: Wire, frame: Frame) -> bool:
        """Whether an end has the bit rate of the bus, now; its log tells which frame it missed."""
        own = wire.bit_rate()
        if own is None or own == self.bit_rate:
            wire.cut_off = ""
            return True
        wire.cut_off = f"its bit rate is {own} bit/s, that of the bus {self.bit_rate}"
        wire.events.add_refusal(frame, wire.cut_off)
        return False

    def advance(self, seconds: float) -> None:
        """Let time pass; frames are delivered at the moment they are sent."""
        self.advance_to(self.clock.now + seconds)

    def advance_to(self, time: float) -> None:
        """Let time pass up to a moment."""
        if self._touched:
            self._see_to_touched()
        self.clock.advance_to(time, self.deliver)
