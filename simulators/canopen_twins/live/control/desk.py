"""Where the threads meet: what the port's asks, the twins' thread does, and the port's waits."""

import asyncio
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import Any, TypeVar

from fastapi import HTTPException

from canopen_twins.bench.twin import carry_out
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown
from canopen_twins.live.control.events import Events
from canopen_twins.live.control.scenarios import Scenarios
from canopen_twins.live.control.schema import Done
from canopen_twins.live.control.stream import Streams
from canopen_twins.live.control.view import in_portions
from canopen_twins.live.orders import Orders
from canopen_twins.scenario import Player

PATIENCE = 10.0  # seconds for the twins to do what they are asked
LOOK = 0.1  # seconds between two looks whether a scenario is over

Answer = TypeVar("Answer")


class Desk:
    """Asks the thread of the twins, and waits without holding the others up."""

    def __init__(self, segment: Segment[Node], orders: Orders, player: Player | None) -> None:
        self.segment = segment
        self.events = Events(segment, orders)
        self.streams = Streams(self.events)
        self.scenarios = Scenarios(segment, self.events, player)
        self.nodes = {node.wire.name: node for node in segment.nodes}
        self._orders = orders
        self._looking: asyncio.Task[None] | None = None

    def node(self, name: str) -> Node:
        """A node by its name or its node id; raises `HTTPException` with 404 if there is none."""
        if name in self.nodes:
            return self.nodes[name]
        for node in self.nodes.values():
            if name == str(node.node_id):
                return node
        raise HTTPException(404, str(unknown("node", name, self.nodes)))

    async def fault(self, node: str, fault: str) -> Node:
        """The node, if it has a fault of this name; raises as `node` does."""
        found = self.node(node)
        try:
            await self.ask(lambda: found.faults.find(fault))
        except UserError as refusal:
            raise HTTPException(404, str(refusal)) from None
        return found

    async def ask(self, action: Callable[[], Answer]) -> Answer:
        """What comes of an action that is short.

        Raises:
            UserError: as the action does.
            HTTPException: 503 if the twins have stopped.
        """
        return await self._have(self._orders.put(action))

    async def collect(self, items: Iterable[Answer]) -> list[Answer]:
        """What there is of something long; raises as `ask` does."""
        return await self._have(self._orders.put_portions(in_portions(items)))

    async def order(self, node: Node, word: str, *arguments: Any) -> Done:
        """One of `ORDERS`, with the moment at which it took effect; raises as `ask` does."""
        return Done(await self.ask(lambda: carry_out(self.segment, node, word, *arguments)))

    def look_after_scenario(self) -> None:
        """See to it that a scenario that is over leaves the bus."""
        if self._looking is None or self._looking.done():
            self._looking = asyncio.create_task(self._look())

    async def _look(self) -> None:
        while await self.ask(lambda: self.scenarios.running):
            await asyncio.sleep(LOOK)

    async def _have(self, future: "Future[Answer]") -> Answer:
        try:
            return await asyncio.wait_for(asyncio.wrap_future(future), PATIENCE)
        except (TimeoutError, asyncio.CancelledError):
            raise HTTPException(503, "the twins do not answer") from None
