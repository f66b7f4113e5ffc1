"""How a node is: the values of its objects, and the NMT state it enters."""

from collections.abc import Sequence
from dataclasses import dataclass

from simulators.node import Node
from simulators.objects import Address, Rejected
from simulators.replay.signs.sign import Changed, Happening, Sign
from simulators.replay.signs.wanted import Wanted
from simulators.replay.targets import Target
from simulators.services import State


@dataclass(frozen=True)
class Holds(Sign):
    """Objects have values; the look at them leaves no trace on the bus nor in the device."""

    wanted: tuple[tuple[Target, Wanted], ...]
    looks = True

    @property
    def addresses(self) -> Sequence[Address]:
        """All of them."""
        return [target.address for target, _ in self.wanted]

    def look(self, node: Node) -> tuple[bool, str]:
        """Whether all of them hold at this moment."""
        values = [(target, wanted, _value(node, target)) for target, wanted in self.wanted]
        told = (f"{target} is {_told(wanted, value)}" for target, wanted, value in values)
        return all(_is(wanted, value) for _, wanted, value in values), ", ".join(told)

    def __str__(self) -> str:
        return ", ".join(f"{target} {wanted}" for target, wanted in self.wanted)


@dataclass(frozen=True)
class Entered(Sign):
    """The node enters an NMT state; one that is in it already does not."""

    state: State

    def sees(self, happening: Happening, node: Node) -> bool:
        """This state."""
        return self.is_kin(happening, node) and self.state is _state(happening)

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """Any state of the node."""
        return isinstance(happening, Changed) and happening.node is node

    def tell(self, happening: Happening) -> str:
        """The state."""
        return _state(happening).lower()

    def __str__(self) -> str:
        return f"state {self.state.lower()}"


def _state(happening: Happening) -> State:
    assert isinstance(happening, Changed)
    return happening.state


class NoValue(str):
    """Why there is none; whatever is wanted, this is not it."""

    __slots__ = ()


def _is(wanted: Wanted, value: object) -> bool:
    return not isinstance(value, NoValue) and value in wanted


def _told(wanted: Wanted, value: object) -> str:
    return str(value) if isinstance(value, NoValue) else wanted.tell(value)


def _value(node: Node, target: Target) -> object:
    if node.slave is None:
        return NoValue("(silent)")
    try:
        entry = node.slave.entry(*target.address)
        return entry.unpack(entry.read())
    except Rejected as refusal:
        return NoValue(f"(refused: {refusal})")
