"""Records of runs: what was on the bus and why, to be lived through again and compared."""

from simulators.record.about import about
from simulators.record.again import again
from simulators.record.recorded import Recorded
from simulators.record.recorder import record
from simulators.record.side import Side
from simulators.record.trace import Observer, print_frames, trace_file
from simulators.record.words import differences

__all__ = [
    "Observer",
    "Recorded",
    "Side",
    "about",
    "again",
    "differences",
    "print_frames",
    "record",
    "trace_file",
]
