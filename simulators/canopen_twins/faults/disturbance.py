"""Faults around every node: which frames are struck, what becomes of them, and when it is over."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from enum import IntEnum
from functools import partial
from random import Random
from typing import Any, NamedTuple

from canopen_twins.bus.clock import Scope
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import Filter, Onward
from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.device.node import Node
from canopen_twins.faults.weather import WEATHER
from canopen_twins.slave.slave import Slave

AIM: Mapping[str, Parameter] = {
    "nth": Parameter("the first one that is struck, counted from 1", 1, int, low=1),
    "times": Parameter("how many are struck before it heals by itself; 0: no end", 0, int, low=0),
    "probability": Parameter("the chance of each to be struck, 0..1", 1.0, low=0, high=1),
    "burst": Parameter("how many in a row are struck once chance has it", 1, int, low=1),
    "seed": Parameter("where chance begins: the same seed, the same frames", 1, int),
}
"""The parameters that every fault has whose victims come one after the other."""


class Aim:
    """Which of the frames or accesses that fit are struck: counted, or by seeded chance.

    It is asked once for each that fits.
    """

    def __init__(
        self,
        nth: int = 1,
        times: int = 0,
        probability: float = 1.0,
        burst: int = 1,
        seed: int = 1,
    ) -> None:
        self._before = nth - 1
        self._times = times
        self._probability = probability
        self._burst = burst
        self._chance = Random(seed)
        self._struck = 0
        self._in_a_row = 0

    @property
    def over(self) -> bool:
        """Whether nothing is struck any more."""
        return 0 < self._times <= self._struck

    def strikes(self) -> bool:
        """Whether the one that has come is struck."""
        if self._before or self.over:
            self._before = max(self._before - 1, 0)
            return False
        if not self._in_a_row and self._chance.random() < self._probability:
            self._in_a_row = self._burst
        if not self._in_a_row:
            return False
        self._in_a_row -= 1
        self._struck += 1
        return True


class Place(NamedTuple):
    """Where something goes wrong: at a node, among the nodes of its segment."""

    node: Node
    nodes: list[Node]


Effect = Callable[[Frame], Iterable[tuple[float, Frame]]]
"""The frames that go on instead, each after so many seconds."""


def lost(frame: Frame) -> Iterable[tuple[float, Frame]]:
    """Nothing comes out."""
    return ()


def doubled(frame: Frame) -> Iterable[tuple[float, Frame]]:
    """The same frame twice."""
    return (0.0, frame), (0.0, frame)


def late(seconds: float) -> Effect:
    """The frame, but later."""
    return lambda frame: [(seconds, frame)]


def repeated(times: int, seconds: float) -> Effect:
    """The frame, and again `times` times, every so many seconds."""
    return lambda frame: [(n * seconds, frame) for n in range(times + 1)]


def altered(change: Callable[[bytes], bytes]) -> Effect:
    """The frame with other data."""
    return lambda frame: [(0.0, frame._replace(data=change(frame.data)))]


def renamed(can_id: int) -> Effect:
    """The frame with another identifier."""
    return lambda frame: [(0.0, frame._replace(can_id=can_id))]


def frozen() -> Effect:
    """The first frame of each identifier for ever."""
    first: dict[int, Frame] = {}
    return lambda frame: [(0.0, first.setdefault(frame.can_id, frame))]


def jittered(place: Place, seconds: float, seed: int) -> Effect:
    """Each frame later by a time of its own, up to so many seconds; none overtakes another."""
    chance, last, clock = Random(seed), 0.0, place.node.clock

    def effect(frame: Frame) -> Iterable[tuple[float, Frame]]:
        nonlocal last
        last = max(last, clock.now + chance.uniform(0, seconds))
        return [(last - clock.now, frame)]

    return effect


def corrupted(bits: int, seed: int) -> Effect:
    """The frame with some bits of its data the other way round."""
    chance = Random(seed)

    def change(data: bytes) -> bytes:
        positions = chance.sample(range(8 * len(data)), min(bits, 8 * len(data)))
        mask = sum(1 << position for position in positions)
        return (int.from_bytes(data) ^ mask).to_bytes(len(data))

    return altered(change)


Fits = Callable[[Node, Frame], bool]
"""Whether a frame, to or from a node, is one of those that are aimed at."""


def anything(node: Node, frame: Frame) -> bool:
    """Every frame."""
    return True


class Side(IntEnum):
    """Where between the device and the bus a filter stands."""

    DEVICE = 0
    PROTOCOL = 1
    LINE = 2


class Disturbance:
    """Its timers end with it: what it still holds back then is lost."""

    name = ""
    """That of its fault."""

    def __init__(self, place: Place) -> None:
        self.node = place.node
        self.clock = Scope(place.node.clock)

    @property
    def over(self) -> bool:
        """Whether it is over by itself."""
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

    def __init__(self, place: Place, fits: Fits, effect: Effect, **aim: Any) -> None:
        super().__init__(place)
        self._fits = fits
        self._effect = effect
        self._aim = Aim(**aim)
        self._held = 0
        self._running = False

    @property
    def over(self) -> bool:
        """Nothing will be struck any more, and nothing is held back."""
        return self._aim.over and not self._held

    def start(self) -> None:
        """Stand in the way."""
        self._running = True
        self.node.wire.outgoing.append(self)
        self.node.wire.outgoing.sort(key=_side)
        if self.both_ways:
            wire = self.node.wire
            wire.filter_incoming(sorted((*wire.incoming, self), key=_side, reverse=True))

    def stop(self) -> None:
        """Get out of the way."""
        super().stop()
        self._running = False
        self.node.wire.outgoing.remove(self)
        if self.both_ways:
            wire = self.node.wire
            wire.filter_incoming([each for each in wire.incoming if each is not self])

    def __call__(self, frame: Frame, onward: Onward) -> None:
        """Strike, or let pass; a frame that was held back elsewhere may come when it has ended."""
        if self._running and self._fits(self.node, frame) and self._aim.strikes():
            self.note(frame)
            self.strike(frame, onward)
        else:
            onward(frame)

    def note(self, frame: Frame) -> None:
        """Remember that a frame is struck: whoever asks why may come when it is over."""
        self.node.wire.events.add_strike(frame, self.name)

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
        its_own = self.node.slave is sender and not (sender and sender.shut)
        if self.side is Side.LINE or its_own:
            onward(frame)


def _side(filter: Filter) -> Side:
    return getattr(filter, "side", Side.PROTOCOL)


class FaultType(NamedTuple):
    """A fault that every device has: a row of the table of its level."""

    text: str
    sees: str
    parameters: Mapping[str, Parameter]
    make: Callable[..., Disturbance]
    """Called with a place and every parameter as a keyword."""


def fault(name: str, type: FaultType, level: str, place: Place) -> Fault:
    """A fault of a type at a place, by its name."""
    running: list[Disturbance] = []

    def inject(**values: object) -> None:
        disturbance = type.make(place, **values)
        disturbance.name = name
        running.append(disturbance)
        disturbance.start()

    def clear(**values: object) -> None:
        running.pop().stop()

    def over() -> bool:
        return all(disturbance.over for disturbance in running)

    return Fault(type.text, inject, clear, type.parameters, level, type.sees, over, WEATHER[name])
