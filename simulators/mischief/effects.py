"""What happens to a frame that is struck: which frames come out of it, and after how long."""

from collections.abc import Callable, Iterable
from random import Random

from simulators.clock import Timing
from simulators.frame import Frame

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


def jittered(clock: Timing, seconds: float, seed: int) -> Effect:
    """Each frame later by a time of its own, up to so many seconds; none overtakes another."""
    chance, last = Random(seed), 0.0

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
