"""What a step does by itself: it changes the plant, the supply or the bus, and is done."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.scenario.context import Context
from canopen_twins.scenario.scenario import Action, Condition


@dataclass(frozen=True)
class Set(Action):
    """Changes live settings, such as the load, as an operator or the plant would."""

    settings: Mapping[str, Any]

    def carry_out(self, context: Context) -> None:
        """All of them at once."""
        with context.node.acting() as device:
            device.set(**self.settings)


@dataclass(frozen=True)
class Send(Action):
    """Any frame, such as a SYNC."""

    frame: Frame

    def carry_out(self, context: Context) -> None:
        """As a master."""
        context.send(self.frame)


@dataclass(frozen=True)
class Limit(Action):
    """A bit rate for the bus; it is there before the first step, or never."""

    bit_rate: int

    def __str__(self) -> str:
        return f"bit rate of {self.bit_rate} bit/s"


@dataclass(frozen=True)
class Nmt(Action):
    """A command of the NMT master to the node."""

    command: int

    def carry_out(self, context: Context) -> None:
        """To the node id it has by now."""
        context.send(Frame(0x000, bytes([self.command, context.node.node_id])))


@dataclass(frozen=True)
class Power(Action):
    """Switches the supply of the node."""

    switch: Callable[[Node], None]

    def carry_out(self, context: Context) -> None:
        """On or off; without effect if it is so already."""
        self.switch(context.node)


@dataclass(frozen=True)
class Inject(Action):
    """Something goes wrong, and perhaps heals by itself."""

    faults: Mapping[str, Mapping[str, Any]]
    lasts: float | Condition | None = None
    """Seconds, or what heals it; None: until it is cleared."""

    def carry_out(self, context: Context) -> None:
        """In the order of the file."""
        context.inject(self.faults, self.lasts)


@dataclass(frozen=True)
class Clear(Action):
    """A cause goes away; the device recovers as far as it does by itself."""

    fault: str | None
    """None for all of them."""

    def carry_out(self, context: Context) -> None:
        """Without effect if it is not active."""
        context.clear(self.fault)
