"""Line level: frames are lost, late, doubled, altered, or crowded by those of others."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from canopen_twins.bus.frame import STANDARD_IDS, Frame, length, pattern
from canopen_twins.bus.wire import ErrorState, Onward, Wire
from canopen_twins.device.faults import Parameter
from canopen_twins.faults.disturbance import (
    AIM,
    Disturbance,
    Effect,
    FaultType,
    Filtering,
    Fits,
    Place,
    Side,
    anything,
    corrupted,
    doubled,
    jittered,
    late,
    lost,
)
from canopen_twins.slave.slave import Slave


class LineFilter(Filtering):
    """Both what the node sends and what it hears."""

    both_ways = True
    side = Side.LINE


class ErrorPassive(LineFilter):
    """Only what the node sends; its CAN controller knows."""

    both_ways = False

    def start(self) -> None:
        """The controller has counted too many errors."""
        super().start()
        self.node.wire.error_state = ErrorState.PASSIVE

    def _release(self, frame: Frame, onward: Onward, sender: Slave | None) -> None:
        """With the last one that had to be repeated it is error active again."""
        super()._release(frame, onward, sender)
        if self.over:
            with self.node.acting():
                self.node.wire.error_state = ErrorState.ACTIVE

    def stop(self) -> None:
        """It has counted enough frames without one."""
        super().stop()
        self.node.wire.error_state = ErrorState.ACTIVE


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
        super().__init__(place, anything, lost)
        self._seconds = seconds
        self._recovered = False

    @property
    def over(self) -> bool:
        """The node is on the bus again."""
        return self._recovered

    def start(self) -> None:
        """Off the bus, for a while or until cleared."""
        super().start()
        self.node.wire.error_state = ErrorState.BUS_OFF
        if self._seconds:
            self.clock.after(self._seconds, self._recover)

    def stop(self) -> None:
        """It has been told to recover."""
        super().stop()
        self.node.wire.error_state = ErrorState.ACTIVE

    def _recover(self) -> None:
        with self.node.acting():
            self._running = False
            self._recovered = True
            self.node.wire.error_state = ErrorState.ACTIVE


class Load(Disturbance):
    """Frames that concern nobody, so many that they take a share of the bus."""

    def __init__(self, place: Place, percent: float, kilobits: int, cob_id: int) -> None:
        super().__init__(place)
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


LOOK = "185#D007xxxx: x is any digit, * any rest"
FRAME = {"frame": Parameter(LOOK, "xxx#*", str)}
ONE_AFTER_THE_OTHER = {"frame": Parameter(LOOK, kind=str)}
SECONDS = Parameter("by how much, in s", 0.01, low=0)


def line(place: Place, effect: Effect, frame: str, **aim: Any) -> Filtering:
    """Strikes the frames that look like a pattern, whoever sends them."""
    return LineFilter(place, looks_like(frame), effect, **aim)


LINE: Mapping[str, FaultType] = {
    "frame_lost": FaultType(
        "A frame does not arrive.",
        "A gap: a request to be repeated, a cycle missed, a time-out.",
        {**FRAME, **AIM},
        lambda place, frame, **aim: line(place, lost, frame, **aim),
    ),
    "frame_doubled": FaultType(
        "A frame arrives twice.",
        "The same once more: no second action, no toggle error, no answer to what it did not ask.",
        {**FRAME, **AIM},
        lambda place, frame, **aim: line(place, doubled, frame, **aim),
    ),
    "frame_late": FaultType(
        "A frame arrives late; others may overtake it.",
        "Old data after new, an answer after the time-out.",
        {"seconds": SECONDS, **FRAME, **AIM},
        lambda place, seconds, frame, **aim: line(place, late(seconds), frame, **aim),
    ),
    "frame_jitter": FaultType(
        "Frames arrive late, each by another time; none overtakes another.",
        "Irregular cycles: no alarm below the limit, one above.",
        {"seconds": SECONDS, **FRAME, **AIM},
        lambda place, seconds, frame, **aim: line(
            place, jittered(place, seconds, aim["seed"]), frame, **aim
        ),
    ),
    "frame_swapped": FaultType(
        "A frame and the next one like it change places.",
        "The older one last: an old value is not to win over a new one.",
        {**ONE_AFTER_THE_OTHER, **AIM},
        lambda place, frame, **aim: Swapped(place, looks_like(frame), lost, **aim),
    ),
    "frame_corrupt": FaultType(
        "Bits of the data are inverted behind the CRC, as by a faulty controller or gateway.",
        "A value that cannot be: out of its limits, not plausible; an answer that is none.",
        {"bits": Parameter("how many of its bits", 1, int, low=1, high=64), **FRAME, **AIM},
        lambda place, bits, frame, **aim: line(place, corrupted(bits, aim["seed"]), frame, **aim),
    ),
    "error_passive": FaultType(
        "The node is error passive: all it sends has to be repeated and comes late, in order.",
        "Irregular cycles of one node; EMCY 0x8120 if the device knows it (compose: emcy_storm).",
        {"seconds": Parameter("at most by how much, in s", 0.005, low=0), **AIM},
        lambda place, seconds, **aim: ErrorPassive(
            place, anything, jittered(place, seconds, aim["seed"]), **aim
        ),
    ),
    "bus_off": FaultType(
        "The node is bus off: it neither sends nor hears, and goes on as it was after that.",
        "Silence, then heartbeats again without a boot-up, and EMCY 0x8140 if the device knows it:"
        " nothing of its state may be assumed.",
        {"seconds": Parameter("until it recovers, in s; 0: when cleared", 0.0, low=0)},
        BusOff,
    ),
    "bus_load": FaultType(
        "Frames of others take a share of the bus.",
        "Interrupts and queues that fill: no frame of this node may be lost.",
        {
            "percent": Parameter("their share of the bus", 50.0, low=0.1, high=100),
            "kilobits": Parameter("bit rate of the bus, in kbit/s", 250, int, 10, 1000),
            "cob_id": Parameter("their identifier", 0x7FE, int, low=1, high=STANDARD_IDS[-1]),
        },
        Load,
    ),
}
