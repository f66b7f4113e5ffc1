"""What can go wrong with both units, with what joins them, and around them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simulators.faults import Fault

if TYPE_CHECKING:
    from simulators.devices.gateway import Device


def faults(device: Device) -> Mapping[str, Fault]:
    """Every fault by its name."""
    return {}
