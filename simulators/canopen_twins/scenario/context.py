"""What an action acts on, and whom it tells."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.scenario.scenario import Condition
from canopen_twins.scenario.sdo import Answer, Transfer
from canopen_twins.scenario.verdict import Finding

if TYPE_CHECKING:
    from canopen_twins.scenario.expect import Expectation


class Context(Protocol):
    """One step being carried out."""

    @property
    def node(self) -> Node:
        """The node the step is about."""

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus as a master."""

    def ask(
        self,
        transfers: Sequence[Transfer],
        patience: float,
        answered: Callable[[int, Answer], bool],
    ) -> None:
        """SDO transfers with the node, one after the other, each waited for so many seconds.

        `answered` takes the number of the transfer, counted from 0, and what came of it; whether to
        go on. The step has been carried out when all is done.
        """

    def inject(
        self, faults: Mapping[str, Mapping[str, Any]], lasts: float | Condition | None
    ) -> None:
        """Let things go wrong with the node, until it is cleared or heals by itself."""

    def clear(self, fault: str | None) -> None:
        """Take a fault of the node away, or all of them."""

    def report(self, finding: Finding) -> None:
        """Take what has been decided at once."""

    def watch_for(self, expectation: Expectation) -> None:
        """Take what will be decided."""
