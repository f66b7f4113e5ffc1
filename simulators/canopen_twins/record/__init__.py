"""Records of runs: what was on the bus and why, to be lived through again and compared."""

from canopen_twins.record.about import about
from canopen_twins.record.differences import Side, differences
from canopen_twins.record.recorded import Recorded, reproduce
from canopen_twins.record.recorder import record
from canopen_twins.record.trace import Observer, trace_file

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
