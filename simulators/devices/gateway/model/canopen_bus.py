"""CAN2 controller of the gateway: what leaves, and how it gets over a bus fault (12423)."""

from dataclasses import dataclass, field
from typing import NamedTuple

from simulators.devices.gateway.model.state import State

RETRY_CYCLES = 31  # main cycles: half a second


@dataclass(frozen=True)
class BootUp:
    """The boot-up message: initialised, or over a bus fault without heartbeats (A-10)."""


@dataclass(frozen=True)
class Heartbeat:
    """The heartbeat that tells of the end of a bus fault; those in between are a matter of time."""

    state: State


class TpdoFrame(NamedTuple):
    """A TPDO 1..16 with the words it carries."""

    number: int
    words: tuple[int, ...]


Message = BootUp | Heartbeat | TpdoFrame


@dataclass
class Plug:
    """The CANopen plug of the gateway: what was sent, and whether the bus is disturbed."""

    outbox: list[Message] = field(default_factory=list)
    """What is new, oldest first; whoever has put it on the bus clears the list."""
    fault: bool = False


@dataclass
class CanopenBus:
    """The CAN2 controller: once disturbed it is dead until it was initialised with success."""

    plug: Plug
    failed: bool = False
    """3072."""
    _age: int = 0

    @property
    def alive(self) -> bool:
        """Whether frames get in and out."""
        return not self.failed and not self.plug.fault

    def send(self, message: Message) -> None:
        """Send, or lose the message."""
        if self.alive:
            self.plug.outbox.append(message)

    def step(self) -> None:
        """One main cycle: notice a fault; initialise again every half second."""
        if not self.failed:
            self.failed, self._age = self.plug.fault, 0
            return
        self._age += 1
        if self._age == RETRY_CYCLES:
            self.failed, self._age = self.plug.fault, 0
