"""Records of runs: what was on the bus and why, to be lived through again and compared."""

from simulators.record.about import about
from simulators.record.differences import differences
from simulators.record.recorded import Recorded
from simulators.record.recorder import record
from simulators.record.reproduce import reproduce
from simulators.record.side import Side
from simulators.record.trace import Observer, trace_file

__all__ = [
    "Observer",
    "Recorded",
    "Side",
    "about",
    "differences",
    "record",
    "reproduce",
    "trace_file",
]
