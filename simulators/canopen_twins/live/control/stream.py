"""Events as server-sent events: each client has room for so many, and is dropped if it is slow."""

import asyncio
import json
import logging
from collections import deque
from collections.abc import AsyncIterator, Collection
from typing import NamedTuple

from starlette.responses import StreamingResponse
from starlette.types import Message, Send

from canopen_twins.live.control.events import KINDS, Events
from canopen_twins.live.control.schema import Event

log = logging.getLogger(__name__)

ROOM = 5_000  # events that wait for one client
MOST_CLIENTS = 16
PERIOD = 0.05  # seconds between two looks at what there is to tell
QUIET = 10.0  # seconds until a line of comment shows that the connection is alive

STALL = 5.0  # seconds for a client to take what it is sent


class Wanted(NamedTuple):
    """Which events somebody wants; of no node in particular those of all."""

    kinds: Collection[str] = KINDS
    nodes: Collection[str] = ()

    def fits(self, event: Event) -> bool:
        """Whether an event is one of them."""
        return event.kind in self.kinds and (not self.nodes or event.node in self.nodes)


class Client:
    """Somebody who watches, with what waits for it."""

    def __init__(self, wanted: Wanted) -> None:
        self.wanted = wanted
        self.waiting: deque[str] = deque()
        self.dropped = False

    def give(self, event: Event, text: str) -> None:
        """Let it wait, if there is room."""
        if self.wanted.fits(event):
            if len(self.waiting) >= ROOM:
                self.dropped = True
            else:
                self.waiting.append(text)


class Streams:
    """Everybody who watches; one task takes the events for all of them while there are any."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._clients: list[Client] = []
        self._task: asyncio.Task[None] | None = None
        self.closing = False

    @property
    def full(self) -> bool:
        """Whether nobody more may watch."""
        return len(self._clients) >= MOST_CLIENTS

    async def watch(self, wanted: Wanted) -> AsyncIterator[str]:
        """What is wanted of the events from now on, until the port is closed."""
        client = Client(wanted)
        self._clients.append(client)
        self._events.watched.update(wanted.kinds)
        if self._task is None:
            self._task = asyncio.create_task(self._distribute())
        quiet = 0.0
        try:
            yield ": these are the events\n\n"
            while not (self.closing or client.dropped):
                if client.waiting:
                    quiet = 0.0
                    told = "".join(client.waiting)
                    client.waiting.clear()
                    yield told
                    continue
                await asyncio.sleep(PERIOD)
                quiet += PERIOD
                if quiet >= QUIET:
                    quiet = 0.0
                    yield ":\n\n"
        finally:
            self._clients.remove(client)
            self._events.watched.subtract(wanted.kinds)

    async def _distribute(self) -> None:
        while self._clients:
            for event in self._events.take():
                text = f"event: {event.kind}\ndata: {json.dumps(event, default=vars)}\n\n"
                for client in self._clients:
                    client.give(event, text)
            await asyncio.sleep(PERIOD)
        self._task = None


class EventStream(StreamingResponse):
    """Ends where the client takes nothing any more."""

    media_type = "text/event-stream"

    async def stream_response(self, send: Send) -> None:
        """Each piece in its time."""

        async def send_in_time(message: Message) -> None:
            await asyncio.wait_for(send(message), STALL)

        try:
            await super().stream_response(send_in_time)
        except TimeoutError:
            log.warning("somebody who watches takes nothing any more, and is dropped")
