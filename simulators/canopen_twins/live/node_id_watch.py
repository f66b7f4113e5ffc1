"""Whether another node on the bus has one of our node ids: it sends what only ours does."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import classify
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.live.bus import OWN
from canopen_twins.slave.emcy import emcy_id

if TYPE_CHECKING:
    from canopen_twins.scenario import Player

log = logging.getLogger(__name__)


class NodeIdWatch:
    """Hears a segment, and tells once of each node that has a double.

    Args:
        segment: Whose nodes may have one.
        player: Of a scenario whose verdict has to say so, if there is one.
    """

    def __init__(self, segment: Segment[Node], player: Player | None = None) -> None:
        self.found = ""
        """The first of all, in words."""
        self._nodes = segment.nodes
        self._player = player
        self._known: set[Node] = set()
        segment.listeners.append(self._hear)

    def _hear(self, frame: Frame, sender: str) -> None:
        if sender or frame.remote or frame.extended:
            return
        known = classify(frame.can_id)  # a SYNC is no EMCY of a node 0
        if known is None or known.cob not in OWN:
            return
        for node in self._nodes:
            if node not in self._known and frame.can_id in _own(node):
                self._take(node, frame)

    def _take(self, node: Node, frame: Frame) -> None:
        self._known.add(node)
        told = f"another node on the bus has node id {node.node_id}, too: it has sent {frame}"
        self.found = self.found or f"{node.wire.name}: {told}"
        node.wire.events.add_refusal(frame, told)
        log.warning("%s: %s", node.wire.name, told)
        if self._player is not None:
            self._player.blame(f"node id of {node.wire.name}", told)


def _own(node: Node) -> tuple[int | None, ...]:
    """Identifiers with which nobody sends but the node, as it is now; none while it is silent."""
    if node.slave is None:
        return ()
    id_ = node.node_id
    return identifiers.heartbeat(id_), identifiers.sdo_answer(id_), emcy_id(node.slave)
