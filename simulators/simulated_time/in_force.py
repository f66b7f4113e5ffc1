"""The simulated time of this process: there is one, or none."""

from simulators.node import Node
from simulators.segment import Segment
from simulators.simulated_time.baton import Baton
from simulators.simulated_time.task import Ready, SimulatedTimeError

_current: list[Baton] = []


def begin(segment: Segment[Node], patience: float) -> Baton:
    """Let simulated time be that of a segment.

    Raises:
        SimulatedTimeError: it is in force already.
    """
    if _current:
        raise SimulatedTimeError("simulated time is in force already: leave it before you enter it")
    _current.append(Baton(segment, patience))
    return _current[0]


def cease() -> None:
    """Go back to real time."""
    _current.clear()


def baton() -> Baton:
    """Who may run.

    Raises:
        SimulatedTimeError: simulated time is not in force.
    """
    if not _current:
        raise SimulatedTimeError("simulated time is over: what was made in it waits no more")
    return _current[0]


def wait(ready: Ready, timeout: float | None = None) -> bool:
    """See `Baton.wait`."""
    return baton().wait(ready, timeout)


def changed() -> None:
    """See `Baton.changed`; nobody waits when simulated time is over."""
    if _current:
        _current[0].changed()
