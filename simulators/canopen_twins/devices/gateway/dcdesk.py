"""What both units keep without power, and DcDesk, which changes it (7 to 9)."""

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from canopen_twins.devices.gateway.model.gateway import Gateway
from canopen_twins.devices.gateway.model.governor import Governor
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.devices.gateway.model.unit import Life
from canopen_twins.errors import UserError
from canopen_twins.slave.memory import Memory

log = logging.getLogger(__name__)

PARAMETERS = "parameters"


class NonVolatile:
    """Two sections of a memory, one for each unit.

    A unit whose parameters were saved by DcDesk has them; otherwise those it was delivered with.
    """

    def __init__(
        self, system: System, delivered: Mapping[str, Mapping[int, float]], memory: Memory
    ) -> None:
        """Begin with what the memory has.

        Raises:
            UserError: it is not the memory of a gateway, or the configuration is refused.
        """
        self._system, self._memory = system, memory
        self._delivered = delivered
        kept = {unit: memory.load(unit) for unit in system.kept}
        self._saved = {unit for unit, section in kept.items() if PARAMETERS in section}
        try:
            self.deliver()
            system.restore(kept)
        except ValueError as refusal:
            raise UserError(str(refusal)) from refusal
        self._counts = self._counted()

    def deliver(self) -> None:
        """Let both units have the parameters they should have, whatever they have now."""
        for unit in (self._system.governor, self._system.gateway):
            name = unit.which.value
            unit.store.saved = {}
            self._system.configure({name: self._parameters(name)})

    def _parameters(self, name: str) -> Mapping[int, float]:
        if name not in self._saved:
            return self._delivered.get(name, {})
        saved: Mapping[str, float] = self._memory.load(name)[PARAMETERS]
        return {int(number): value for number, value in saved.items()}

    def misconfigure(self, content: Mapping[str, Mapping[int, float]]) -> None:
        """Let the units have other parameters, and restart both.

        Raises:
            UserError: a parameter that is out of its range.
        """
        try:
            self._system.configure(content)
        except ValueError as refusal:
            raise UserError(str(refusal)) from refusal
        self._restart()

    def put_right(self) -> None:
        """Let the units have the parameters they should have, and restart both."""
        self.deliver()
        self._restart()

    def _restart(self) -> None:
        if self._system.governor.life is not Life.OFF:
            self._system.power_on()

    def save(self, unit: Governor | Gateway) -> None:
        """Keep the parameters of a unit as they are."""
        self._saved.add(unit.which.value)
        self.keep()

    def keep(self) -> None:
        """Keep everything; a memory that cannot be written is reported."""
        self._counts = self._counted()
        try:
            for name, values in self._system.kept.items():
                left_out = () if name in self._saved else (PARAMETERS,)
                self._memory.store(name, {k: v for k, v in values.items() if k not in left_out})
        except OSError as failure:
            log.error("the memory cannot be written: %s", failure)

    def keep_news(self) -> None:
        """Keep everything if an error was counted since the last time."""
        if self._counts != self._counted():
            self.keep()

    def _counted(self) -> int:
        """How often anything was counted; a counter that stays at its end says nothing new."""
        system = self._system
        return sum(system.governor.memory.counts.values()) + sum(
            system.gateway.memory.counts.values()
        )


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
