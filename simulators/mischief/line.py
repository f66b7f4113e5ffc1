"""Line level: frames on their way to and from a node get lost, late, twice or wrong."""

from collections.abc import Mapping

from simulators.faults import Parameter
from simulators.frame import STANDARD_IDS
from simulators.mischief.disturbance import Filtering, Kind, Place
from simulators.mischief.effects import Effect, corrupted, doubled, jittered, late, lost
from simulators.mischief.line_filters import (
    BusOff,
    LineFilter,
    Load,
    Repeating,
    Swapped,
    anything,
    looks_like,
)
from simulators.mischief.turn import AIM, Turn

LOOK = "185#D007xxxx: x is any digit, * any rest"
FRAME = {"frame": Parameter(LOOK, "xxx#*", str)}
ONE_AFTER_THE_OTHER = {"frame": Parameter(LOOK, kind=str)}
SECONDS = Parameter("by how much, in s", 0.01, low=0)


def line(place: Place, effect: Effect, frame: str, **turn: int) -> Filtering:
    """Strikes the frames that look like a pattern, whoever sends them."""
    return LineFilter(place.node, looks_like(frame), effect, Turn(**turn))


LINE: Mapping[str, Kind] = {
    "frame_lost": Kind(
        "A frame does not arrive.",
        "A gap: a request to be repeated, a cycle missed, a time-out.",
        {**FRAME, **AIM},
        lambda place, frame, **turn: line(place, lost, frame, **turn),
    ),
    "frame_doubled": Kind(
        "A frame arrives twice.",
        "The same once more: no second action, no toggle error, no answer to what it did not ask.",
        {**FRAME, **AIM},
        lambda place, frame, **turn: line(place, doubled, frame, **turn),
    ),
    "frame_late": Kind(
        "A frame arrives late; others may overtake it.",
        "Old data after new, an answer after the time-out.",
        {"seconds": SECONDS, **FRAME, **AIM},
        lambda place, seconds, frame, **turn: line(place, late(seconds), frame, **turn),
    ),
    "frame_jitter": Kind(
        "Frames arrive late, each by another time; none overtakes another.",
        "Irregular cycles: no alarm below the limit, one above.",
        {"seconds": SECONDS, **FRAME, **AIM},
        lambda place, seconds, frame, **turn: line(
            place, jittered(place.node.clock, seconds, turn["seed"]), frame, **turn
        ),
    ),
    "frame_swapped": Kind(
        "A frame and the next one like it change places.",
        "The older one last: an old value is not to win over a new one.",
        {**ONE_AFTER_THE_OTHER, **AIM},
        lambda place, frame, **turn: Swapped(place.node, looks_like(frame), lost, Turn(**turn)),
    ),
    "frame_corrupt": Kind(
        "Bits of the data are inverted behind the CRC, as by a faulty controller or gateway.",
        "A value that cannot be: out of its limits, not plausible; an answer that is none.",
        {"bits": Parameter("how many of its bits", 1, int, low=1, high=64), **FRAME, **AIM},
        lambda place, bits, frame, **turn: line(
            place, corrupted(bits, turn["seed"]), frame, **turn
        ),
    ),
    "error_passive": Kind(
        "The node is error passive: all it sends has to be repeated and comes late, in order.",
        "Irregular cycles of one node; EMCY 0x8120 if the device knows it (compose: emcy_storm).",
        {"seconds": Parameter("at most by how much, in s", 0.005, low=0), **AIM},
        lambda place, seconds, **turn: Repeating(
            place.node, anything, jittered(place.node.clock, seconds, turn["seed"]), Turn(**turn)
        ),
    ),
    "bus_off": Kind(
        "The node is bus off: it neither sends nor hears, and goes on as it was after that.",
        "Silence, then heartbeats again without a boot-up: nothing of its state may be assumed.",
        {"seconds": Parameter("until it recovers, in s; 0: when cleared", 0.0, low=0)},
        BusOff,
    ),
    "bus_load": Kind(
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
