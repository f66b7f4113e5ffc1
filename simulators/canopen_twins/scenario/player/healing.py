"""Faults of scenarios: they come, they go, and some of them heal by themselves."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from canopen_twins.device.node import Node

Tell = Callable[[Node, str, Mapping[str, object]], None]


class Healing:
    """Every fault has one plan at most to be healed: who takes it away or replaces it ends that.

    `tell` hears of what is injected and cleared, with the node.
    """

    def __init__(self, tell: Tell) -> None:
        self._tell = tell
        self._plans: dict[tuple[int, str], object] = {}

    def inject(self, node: Node, faults: Mapping[str, Mapping[str, Any]]) -> None:
        """Let things go wrong, in the order of the file.

        Raises:
            UserError: the node has no such fault.
        """
        with node.acting():
            for name, parameters in faults.items():
                node.faults.inject(name, **parameters)
                self._plans.pop((id(node), name), None)
                self._tell(node, "inject", {"fault": name, "parameters": dict(parameters)})

    def clear(self, node: Node, fault: str | None) -> None:
        """Take one away, or all of them; without effect if it is not active.

        Raises:
            UserError: the node has no such fault.
        """
        with node.acting():
            gone = [name for name in node.faults.active if fault in (None, name)]
            node.faults.clear(fault)
            for name in gone:
                self._plans.pop((id(node), name), None)
                self._tell(node, "clear", {"fault": name})

    def plan(self, node: Node, faults: Iterable[str]) -> Callable[[], None]:
        """What heals those of the faults that are still the same when it is called."""
        plan = object()
        planned = [(id(node), name) for name in faults]
        self._plans.update(dict.fromkeys(planned, plan))

        def heal() -> None:
            for key in planned:
                if self._plans.get(key) is plan:
                    self.clear(node, key[1])

        return heal
