"""A trace of real devices held against their twins: service by service, in words."""

from canopen_twins.record.compare.agreement import Agreement, Difference, Kind, Subject
from canopen_twins.record.compare.comparison import Comparison
from canopen_twins.record.compare.tolerances import Allowed, Tolerances

__all__ = [
    "Agreement",
    "Allowed",
    "Comparison",
    "Difference",
    "Kind",
    "Subject",
    "Tolerances",
]
