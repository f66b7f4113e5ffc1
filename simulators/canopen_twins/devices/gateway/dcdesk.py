"""DcDesk at one control unit: what a service engineer reads, changes, saves and clears (7 to 9)."""

from collections.abc import Iterator
from contextlib import contextmanager

from canopen_twins.devices.gateway.model.machines import Gateway, Governor
from canopen_twins.devices.gateway.nonvolatile import NonVolatile
from canopen_twins.errors import UserError


class DcDesk:
    """Parameters by number or name: `desk["CanOpenSendStatus"] = 1`, `desk[2000]`.

    A change acts after `save` and a reset of the unit, and is lost by a reset without (7). Whatever
    is refused is a `UserError`: no such parameter, out of range, only shown, no answer.
    """

    def __init__(self, unit: Governor | Gateway, nonvolatile: NonVolatile) -> None:
        self._unit, self._nonvolatile = unit, nonvolatile

    def __getitem__(self, key: int | str) -> float:
        with _refusals():
            return self._unit.desk.read(key)

    def __setitem__(self, key: int | str, value: float) -> None:
        with _refusals():
            self._unit.desk.write(key, value)

    def save(self) -> None:
        """Keep what was changed; from now on it comes before the configuration file."""
        self._unit.desk.save()
        self._nonvolatile.save(self._unit)

    def reset(self) -> None:
        """Reset this unit alone, as its reset button does."""
        self._unit.reset()

    def clear_errors(self) -> None:
        """Clear all errors, in the other unit too (9.1)."""
        self._unit.desk.clear_errors()

    def clear_error_memory(self) -> None:
        """Clear the counters from 3100 upward (9.2)."""
        self._unit.desk.clear_error_memory()
        self._nonvolatile.keep()

    def connect(self, node: int = 0, identifier: int = 0) -> None:
        """Plug the PC in: its node number on the HEINZMANN CAN, 0 for none, and who it is (8.3)."""
        self._unit.desk.connect(node, identifier)


@contextmanager
def _refusals() -> Iterator[None]:
    try:
        yield
    except ValueError as refusal:
        raise UserError(str(refusal)) from refusal
