"""What a control unit keeps without power, as values for a file (9.2)."""

from collections.abc import Mapping
from typing import Any

from simulators.devices.gateway.model.errors import COUNTERS, MOST
from simulators.devices.gateway.model.machines import Gateway, Governor

LAST_IDENTIFIER = 3851


def kept(unit: Governor | Gateway) -> dict[str, Any]:
    """Saved parameters, counters of the permanent error memory, exception, last identification."""
    counts = unit.memory.counts
    return {
        "parameters": {str(number): value for number, value in unit.store.saved.items()},
        "errors": {str(number + COUNTERS): counts[number] for number in sorted(counts)},
        "exception": list(unit.exception),
        "last identifier": unit.shown[LAST_IDENTIFIER],
    }


def restore(unit: Governor | Gateway, values: Mapping[str, Any]) -> None:
    """Begin with what was kept; what is not given stays as it is.

    Raises:
        ValueError: something in it is not what this unit keeps.
    """
    try:
        parameters = {int(number): each for number, each in values.get("parameters", {}).items()}
        unit.desk.deliver(unit.desk.checked(parameters))
        for number, count in values.get("errors", {}).items():
            unit.memory.counts[int(number) - COUNTERS] = min(max(0, int(count)), MOST)
        first, second, third, fourth = values.get("exception", unit.exception)
        unit.exception = (int(first), int(second), int(third), int(fourth))
        unit.desk.show(LAST_IDENTIFIER, values.get("last identifier", 0))
    except (AttributeError, TypeError) as reason:
        raise ValueError(f"{unit.which.value}: not what was kept: {reason}") from None
