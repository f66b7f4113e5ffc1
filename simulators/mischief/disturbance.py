"""What stands between a node and its bus from the moment it is injected until it is cleared."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import partial

from simulators.clock import Scope
from simulators.faults import Fault, Parameter
from simulators.frame import Frame
from simulators.mischief.effects import Effect
from simulators.mischief.turn import Turn
from simulators.node import Node
from simulators.slave import Slave
from simulators.wire import Filter, Onward

Fits = Callable[[Node, Frame], bool]


@dataclass(frozen=True)
class Place:
    """Where something goes wrong: at a node, among the nodes of its segment."""

    node: Node
    nodes: list[Node]


class Side(IntEnum):
    """Where between the device and the bus a filter stands."""

    DEVICE = 0
    PROTOCOL = 1
    LINE = 2


class Disturbance:
    """Its timers end with it: what it still holds back then is lost."""

    name = ""
    """That of its fault."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.clock = Scope(node.clock)

    @property
    def over(self) -> bool:
        """Whether it has healed by itself."""
        return False

    def start(self) -> None:
        """Begin."""

    def stop(self) -> None:
        """End, and leave nothing behind."""
        self.clock.close()


class Filtering(Disturbance):
    """Strikes some of the frames that the node sends, or hears.

    The line is nearer to the bus than the protocol; what answers instead of the device is nearest
    to it. So it does not matter in which order they are injected.
    """

    both_ways = False
    side = Side.PROTOCOL

    def __init__(self, node: Node, fits: Fits, effect: Effect, turn: Turn) -> None:
        super().__init__(node)
        self._fits = fits
        self._effect = effect
        self._turn = turn
        self._held = 0
        self._running = False

    @property
    def over(self) -> bool:
        """Nothing will be struck any more, and nothing is held back."""
        return self._turn.over and not self._held

    def start(self) -> None:
        """Stand in the way."""
        self._running = True
        self.node.wire.outgoing.append(self)
        self.node.wire.outgoing.sort(key=_side)
        if self.both_ways:
            self.node.wire.incoming.append(self)
            self.node.wire.incoming.sort(key=_side, reverse=True)

    def stop(self) -> None:
        """Get out of the way."""
        super().stop()
        self._running = False
        self.node.wire.outgoing.remove(self)
        if self.both_ways:
            self.node.wire.incoming.remove(self)

    def __call__(self, frame: Frame, onward: Onward) -> None:
        """Strike, or let pass; a frame that was held back elsewhere may come when it has ended."""
        if self._running and self._fits(self.node, frame) and self._turn.strikes():
            self.note(frame)
            self.strike(frame, onward)
        else:
            onward(frame)

    def note(self, frame: Frame) -> None:
        """Remember that a frame is struck: whoever asks why afterwards may find it healed."""
        self.node.wire.diary.strike(frame, self.name)

    def strike(self, frame: Frame, onward: Onward) -> None:
        """Send onward what comes out of a frame."""
        sender = self.node.slave
        for delay, altered in self._effect(frame):
            if delay:
                self._held += 1
                self.clock.after(delay, partial(self._release, altered, onward, sender))
            else:
                onward(altered)

    def _release(self, frame: Frame, onward: Onward, sender: Slave | None) -> None:
        """What is on the line stays there; what a node has yet to send goes with a reset."""
        self._held -= 1
        if self.side is Side.LINE or self.node.slave is sender:
            onward(frame)


def _side(filter: Filter) -> Side:
    return getattr(filter, "side", Side.PROTOCOL)


@dataclass(frozen=True)
class Kind:
    """One kind of fault that every device has: a row of the table of its level."""

    text: str
    sees: str
    parameters: Mapping[str, Parameter]
    make: Callable[..., Disturbance]
    """Called with a place and every parameter as a keyword."""


def fault(name: str, kind: Kind, level: str, place: Place) -> Fault:
    """A kind of fault at a place, by its name."""
    running: list[Disturbance] = []

    def inject(**values: object) -> None:
        disturbance = kind.make(place, **values)
        disturbance.name = name
        running.append(disturbance)
        disturbance.start()

    def clear(**values: object) -> None:
        running.pop().stop()

    def over() -> bool:
        return all(disturbance.over for disturbance in running)

    return Fault(kind.text, inject, clear, kind.parameters, level, kind.sees, over)
