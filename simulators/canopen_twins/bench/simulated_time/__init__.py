"""Simulated time for unmodified masters: their time-outs, sleeps and threads run on a bench."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType

from canopen_twins.bench.bench import Bench
from canopen_twins.bench.limits import OutOfTime, RealTimeLimit, SimulatedTimeError
from canopen_twins.bench.simulated_time.bus import Buses
from canopen_twins.bench.simulated_time.scheduler import LONGEST, Scheduler, enter, leave
from canopen_twins.bench.simulated_time.substitution import (
    StandIns,
    Substitution,
    modules_named,
)
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node

__all__ = ["SimulatedTimeError", "in_simulated_time", "simulated_time"]

PATIENCE = 10.0  # seconds of real time between two waits of one thread
WALL = 120.0  # seconds of real time


@contextmanager
def simulated_time(
    bench: Bench,
    *modules: ModuleType | str,
    patience: float = PATIENCE,
    longest: float = LONGEST,
    wall: float = WALL,
    watched: Iterable[ModuleType] = (),
) -> Iterator[None]:
    """Whatever canopen, python-can and the named modules wait for, they wait on a bench's clock.

    Inside, `canopen.Network().connect(...)` and `can.Bus(...)` land on the bus of the bench,
    whatever interface they ask for. The named modules (a package brings what has been imported of
    it) find stand-ins for what they use of `time`, `threading` and `queue`. Their threads end with
    the block, at the latest.

    Args:
        bench: Whose clock it is.
        modules: Those of the master.
        patience: Seconds of real time that a thread may take from one of its waits to the next.
        longest: Simulated seconds that may pass while somebody waits inside.
        wall: Seconds of real time that the block may take.
        watched: Further modules, whose `sleep` is refused as `time.sleep` is: that of a test.

    Raises:
        SimulatedTimeError: something cannot work in simulated time, here or in a thread, or a limit
            is reached; the message says where everybody is.
        ImportError: there is no module of a name that is given.
    """
    found = modules_named(modules)
    with in_simulated_time(bench.segment, found, patience, longest, watched) as scheduler:
        try:
            with RealTimeLimit(wall, scheduler.everybody):
                yield
        except OutOfTime as limit:
            raise SimulatedTimeError(str(limit)) from limit
    if scheduler.failure is not None:
        raise scheduler.failure


@contextmanager
def in_simulated_time(
    segment: Segment[Node],
    modules: Iterable[ModuleType],
    patience: float = PATIENCE,
    longest: float = LONGEST,
    watched: Iterable[ModuleType] = (),
) -> Iterator[Scheduler]:
    """The same on a segment, for modules as such; what failed in a thread is not raised.

    There is no limit of real time, and that of simulated time comes as `OutOfTime`.
    """
    with ExitStack() as undo:
        scheduler = enter(segment, patience, longest)
        undo.callback(leave)
        buses = Buses(scheduler)
        substitution = Substitution(StandIns(scheduler, buses.open))
        undo.callback(substitution.undo)
        substitution.apply_to_canopen()
        substitution.apply(modules)
        substitution.refuse_sleep(scheduler, watched)
        undo.callback(buses.close)
        undo.callback(scheduler.end)
        yield scheduler
