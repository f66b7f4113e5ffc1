"""What happens on a bus and at a node, and what it has to be to be a sign of something."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from simulators.frame import Frame
from simulators.node import Node
from simulators.objects import Address
from simulators.services import State


class Sent(NamedTuple):
    """A frame on the bus."""

    frame: Frame
    node: Node | None
    """Who has sent it; None for the master, which is whoever is no node of the scenario."""


class Wrote(NamedTuple):
    """The master writes an object, by SDO or with an RPDO; whether it is refused does not matter.

    An RPDO writes several at once: one after the other.
    """

    node: Node
    address: Address
    data: bytes
    sized: bool = True
    """Whether all of the bytes count; with an SDO the master may leave that to the object."""


class Changed(NamedTuple):
    """A node enters an NMT state."""

    node: Node
    state: State


Happening = Sent | Wrote | Changed


class Sign:
    """Something that can be seen of a node or of the master; `str` says in words what is meant."""

    looks: ClassVar[bool] = False
    """Whether it is seen by a look at the node, not in what happens."""

    @property
    def parts(self) -> tuple[Sign, ...]:
        """The signs that have all to be seen, in any order."""
        return (self,)

    @property
    def addresses(self) -> Sequence[Address]:
        """The objects it is about."""
        return ()

    def sees(self, happening: Happening, node: Node) -> bool:
        """Whether this is what is meant."""
        return False

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """Whether this is worth telling where what is meant has not come; that itself always is."""
        return self.sees(happening, node)

    def tell(self, happening: Happening) -> str:
        """In words what `sees` or `is_kin` has said yes to."""
        raise NotImplementedError

    def look(self, node: Node) -> tuple[bool, str]:
        """Whether it is so now, and how it is in words."""
        raise NotImplementedError
