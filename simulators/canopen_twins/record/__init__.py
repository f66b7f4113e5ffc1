"""Records of runs: what was on the bus and why, to be lived through again and compared."""

from canopen_twins.record.differences import Likeness, Side, differences
from canopen_twins.record.folder import Recorded, record, reproduce
from canopen_twins.record.manifest import Manifest, device_files
from canopen_twins.record.trace import Observer, trace_file

__all__ = [
    "Likeness",
    "Manifest",
    "Observer",
    "Recorded",
    "Side",
    "device_files",
    "differences",
    "record",
    "reproduce",
    "trace_file",
]
