"""What the master makes a node do: NMT commands, and objects it writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from simulators.frame import Frame
from simulators.node import Node
from simulators.objects import Address
from simulators.replay.signs.frames import FrameSign
from simulators.replay.signs.sign import Happening, Sign, Wrote
from simulators.replay.signs.wanted import Wanted
from simulators.replay.targets import Target
from simulators.replay.values import value_of

COMMANDS: Mapping[str, int] = {
    "start": 0x01,
    "stop": 0x02,
    "pre-operational": 0x80,
    "reset-node": 0x81,
    "reset-communication": 0x82,
}
NAMES = {command: name for name, command in COMMANDS.items()}
ALL_NODES = 0
LENGTH = 2


@dataclass(frozen=True)
class Commanded(FrameSign):
    """The NMT master commands the node, or all of them; None: whatever the command."""

    command: int | None = None
    by_master = True

    def fits(self, frame: Frame, node: Node) -> bool:
        """The command itself."""
        return self.resembles(frame, node) and self.command in (None, frame.data[0])

    def resembles(self, frame: Frame, node: Node) -> bool:
        """Any command to the node."""
        is_command = frame.can_id == 0 and len(frame.data) == LENGTH
        return is_command and frame.data[1] in (ALL_NODES, node.node_id)

    def words(self, frame: Frame) -> str:
        """The command by its name."""
        return NAMES.get(frame.data[0], f"{frame.data[0]:#04x}")

    def __str__(self) -> str:
        return f"NMT {NAMES[self.command]}" if self.command is not None else "NMT command"


@dataclass(frozen=True)
class Written(Sign):
    """The master writes objects, by SDO or with an RPDO: all of them, in any order."""

    wanted: tuple[tuple[Target, Wanted], ...]

    @property
    def addresses(self) -> Sequence[Address]:
        """All of them."""
        return [target.address for target, _ in self.wanted]

    @property
    def parts(self) -> tuple[Sign, ...]:
        """Each object is written for itself."""
        return tuple(Written((one,)) for one in self.wanted)

    def sees(self, happening: Happening, node: Node) -> bool:
        """One of the objects, with the value that is meant."""
        return isinstance(happening, Wrote) and any(
            _value(target, happening) in wanted
            for target, wanted in self.wanted
            if (happening.node, happening.address) == (node, target.address)
        )

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """One of the objects."""
        return isinstance(happening, Wrote) and any(
            (happening.node, happening.address) == (node, target.address)
            for target, _ in self.wanted
        )

    def tell(self, happening: Happening) -> str:
        """The object, and the value it is to have."""
        assert isinstance(happening, Wrote)
        return next(
            f"{target} = {wanted.tell(_value(target, happening))}"
            for target, wanted in self.wanted
            if target.address == happening.address
        )

    def __str__(self) -> str:
        return f"write {', '.join(f'{target} = {wanted}' for target, wanted in self.wanted)}"


def _value(target: Target, wrote: Wrote) -> object:
    return value_of(target, wrote.data, wrote.sized)
