"""What stands in the line: filters for both directions, and the frames of others."""

from functools import partial

from simulators.bits import length
from simulators.frame import Frame, pattern
from simulators.mischief.disturbance import Disturbance, Filtering, Fits, Place, Side
from simulators.mischief.effects import lost
from simulators.mischief.turn import Turn
from simulators.node import Node
from simulators.wire import Onward, Wire


class LineFilter(Filtering):
    """Both what the node sends and what it hears."""

    both_ways = True
    side = Side.LINE


class Repeating(LineFilter):
    """Only what the node sends."""

    both_ways = False


class Swapped(LineFilter):
    """Holds a frame back until the next one that fits has passed it."""

    _waiting: tuple[Frame, Onward] | None = None

    @property
    def over(self) -> bool:
        """Nothing waits any more."""
        return super().over and self._waiting is None

    def __call__(self, frame: Frame, onward: Onward) -> None:
        """Let the one that waits follow the one that comes."""
        if self._waiting is None or not self._running or not self._fits(self.node, frame):
            super().__call__(frame, onward)
            return
        (held, its_way), self._waiting = self._waiting, None
        onward(frame)
        its_way(held)

    def strike(self, frame: Frame, onward: Onward) -> None:
        """This one waits."""
        self._waiting = frame, onward


class BusOff(LineFilter):
    """Neither sends nor hears, until the recovery."""

    def __init__(self, place: Place, seconds: float) -> None:
        super().__init__(place.node, anything, lost, Turn())
        self._seconds = seconds
        self._recovered = False

    @property
    def over(self) -> bool:
        """The node is on the bus again."""
        return self._recovered

    def start(self) -> None:
        """Off the bus, for a while or until cleared."""
        super().start()
        if self._seconds:
            self.clock.after(self._seconds, self._recover)

    def _recover(self) -> None:
        self._running = False
        self._recovered = True


class Load(Disturbance):
    """Frames that concern nobody, so many that they take a share of the bus."""

    def __init__(self, place: Place, percent: float, kilobits: int, cob_id: int) -> None:
        super().__init__(place.node)
        self._wire = Wire(place.node.clock, place.node.wire.outbox, "load")
        self._frame = Frame(cob_id, b"\x55" * 8)
        self._period = length(self._frame) / (1000 * kilobits) * 100 / percent

    def start(self) -> None:
        """The first one comes after a period."""
        self.clock.every(self._period, partial(self._wire.put, self._frame))


def looks_like(text: str) -> Fits:
    """Frames of this look.

    Raises:
        UserError: it is no pattern.
    """
    look = pattern(text)
    return lambda node, frame: look.fullmatch(str(frame)) is not None


def anything(node: Node, frame: Frame) -> bool:
    """Every frame."""
    return True
