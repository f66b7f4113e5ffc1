"""Who is connected to the hub, and who is on which bus."""

import time
from typing import Protocol

from simulators.frame import Frame
from simulators.hub.protocol import delivered


class Client(Protocol):
    """What the switch knows of a connection."""

    bus: str
    """Empty for one that is on none."""

    def deliver(self, data: bytes) -> None:
        """Bring it a frame; never waits."""

    def hang_up(self) -> None:
        """End it."""


class Switch:
    """What one client of a bus sends all others on it get, in the order in which it came."""

    def __init__(self) -> None:
        self.clients: dict[Client, None] = {}  # a set that keeps the order
        self._buses: dict[str, dict[Client, None]] = {}

    def join(self, client: Client) -> None:
        """Let a client hear its bus from now on."""
        self._buses.setdefault(client.bus, {})[client] = None

    def leave(self, client: Client) -> None:
        """Forget a client, and a bus on which nobody is left."""
        self.clients.pop(client, None)
        bus = self._buses.get(client.bus, {})
        bus.pop(client, None)
        if not bus:
            self._buses.pop(client.bus, None)

    def send(self, sender: Client, frame: Frame) -> None:
        """Bring a frame to everybody else on the sender's bus."""
        data = delivered(frame, time.time())
        for client in tuple(self._buses[sender.bus]):
            if client is not sender:
                client.deliver(data)
