"""How far a device and its twin may be apart before that is a difference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isclose

from canopen_twins.slave.object import Address


@dataclass(frozen=True)
class Allowed:
    """How far a number may be off: as a share of it, or in digits, whichever is more."""

    share: float = 0.0
    digits: float = 0.0

    def covers(self, one: float, other: float) -> bool:
        """Whether two numbers are as good as the same."""
        return one == other or isclose(one, other, rel_tol=self.share, abs_tol=self.digits)


EXACT = Allowed()


@dataclass(frozen=True)
class Tolerances:
    """What is as good as the same."""

    time: int = 5_000
    """Microseconds."""
    value: Allowed = EXACT
    """Of measured values."""
    objects: Mapping[Address, Allowed | None] = field(default_factory=dict)
    """Of single objects; none for one that is not compared."""
    lost: float = 0.0
    """The share of its frames that a trace may lack."""

    def same(self, address: Address, noise: float | None, one: object, other: object) -> bool:
        """Whether two values of an object are as good as the same.

        `noise` is in digits, of an object that is measured; none of any other.
        """
        if one == other:
            return True
        allowed = self.objects.get(address, EXACT if noise is None else self.value)
        if allowed is None:
            return True
        if not isinstance(one, int | float) or not isinstance(other, int | float):
            return False
        return allowed.covers(one, other) or abs(one - other) <= (noise or 0.0)
