"""A client as the hub has it: from its greeting to its end, and what it gets of its bus."""

import asyncio
import logging
import re
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from itertools import chain, islice
from typing import ClassVar

from canopen_twins.bus.hub.protocol import (
    HubAddress,
    Refused,
    Stream,
    delivered,
    element,
    read_owning,
    read_sent,
)

log = logging.getLogger(__name__)

MOST_CLIENTS = 64
MOST_WAITING = 1 << 20  # bytes for one client, some 20 000 frames
KERNEL_BUFFER = 1 << 18  # bytes for one client; by itself it would grow to several MB
HANDSHAKE = 10.0  # seconds until a client has to be on a bus
FAREWELL = 1.0  # seconds for a client to read why
SETTLING = 0.2  # seconds
ELEMENTS_A_TURN = 16  # of one client, before the others have their turns
OPEN = re.compile(r"open ([A-Za-z0-9_.-]{1,16})")


class Switch:
    """What one client of a bus sends all others on it get, in the order in which it came."""

    def __init__(self) -> None:
        self.clients: dict[Connection, None] = {}  # a set that keeps the order
        self._buses: dict[str, dict[Connection, None]] = {}

    def owner(self, client: "Connection", node_ids: frozenset[int]) -> tuple[int, str] | None:
        """A node id that somebody else on its bus has already, and who."""
        others = [each for each in self.clients if each is not client and each.bus == client.bus]
        for other in others:
            if both := sorted(other.node_ids & node_ids):
                return both[0], other.name
        return None

    def join(self, client: "Connection") -> None:
        """Let a client hear its bus from now on."""
        self._buses.setdefault(client.bus, {})[client] = None

    def leave(self, client: "Connection") -> None:
        """Forget a client, and a bus on which nobody is left."""
        self.clients.pop(client, None)
        bus = self._buses.get(client.bus, {})
        bus.pop(client, None)
        if not bus:
            self._buses.pop(client.bus, None)

    def send(self, sender: "Connection", data: bytes) -> None:
        """Bring frames to everybody else on the sender's bus."""
        for client in tuple(self._buses.get(sender.bus, ())):  # it may have gone with its last word
            if client is not sender:
                client.deliver(data)


class Stage(Enum):
    """How far a client has come."""

    GREETED = "greeted"
    OPENED = "opened"
    JOINED = "joined"


class Connection(asyncio.Protocol):
    """A client from the side of the hub."""

    def __init__(self, switch: Switch) -> None:
        self.bus = ""
        """Empty while it is on none."""
        self.node_ids: frozenset[int] = frozenset()
        """Of its nodes, which nobody else may have on its bus."""
        self.name = ""
        self._switch = switch
        self._stage = Stage.GREETED
        self._stream = Stream()
        self._heard: Iterator[str] = iter(())  # what it has said and has not been done yet
        self._sent: list[bytes] = []  # its frames of this turn
        self._backlog = bytearray()  # what the connection does not take at the moment
        self._takes = True
        self._settling: bytearray | None = None  # what is kept back for a moment
        self._end: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Greet, or send away."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        connection: socket.socket = transport.get_extra_info("socket")
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BUFFER)
        transport.set_write_buffer_limits(high=0)  # see `pause_writing`
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        peer = transport.get_extra_info("peername")  # none if it is gone again
        self.name = str(HubAddress(*peer[:2])) if peer else "somebody"
        if len(self._switch.clients) >= MOST_CLIENTS:
            self._refuse(f"there are {MOST_CLIENTS} clients already")
            return
        self._switch.clients[self] = None
        asyncio.get_running_loop().call_later(HANDSHAKE, self._hurry)
        self._write(element("hi"))

    def data_received(self, data: bytes) -> None:
        """Do what it says."""
        self._settle()  # whoever speaks has read what it was told
        self._heard = chain(self._heard, self._stream.feed(data))
        self._take_turn()

    def _take_turn(self) -> None:
        """Do a little of what it says, then let the others have theirs; read on when it is done."""
        done = 0
        try:
            for text in islice(self._heard, ELEMENTS_A_TURN):
                done += 1
                if not self._transport.is_closing():
                    self._obey(text)
        except Refused as refusal:
            self._pass_on()
            self._refuse(str(refusal))
            return
        self._pass_on()
        if self._transport.is_closing():
            return
        if done == ELEMENTS_A_TURN:
            self._transport.pause_reading()
            asyncio.get_running_loop().call_soon(self._take_turn)
        else:
            self._transport.resume_reading()

    def connection_lost(self, exc: Exception | None) -> None:
        """It has gone."""
        self._switch.leave(self)
        if self._end is not None:
            self._end.cancel()
        log.info("%s has gone", self.name)

    def deliver(self, data: bytes) -> None:
        """Bring it what another client has sent; never waits."""
        if self._settling is None:
            self._write(data)
        else:
            self._settling += data
            self._check(len(self._settling))

    def pause_writing(self) -> None:
        """It does not read: what comes now is kept in one piece, not as thousands of writes.

        From Python 3.12 on asyncio keeps every write by itself and counts all of them at each.
        """
        self._takes = False

    def resume_writing(self) -> None:
        """It has read everything."""
        self._takes = True
        if self._backlog:
            backlog, self._backlog = self._backlog, bytearray()
            self._write(bytes(backlog))

    def hang_up(self) -> None:
        """End the connection; what has been written goes out, if it is read soon."""
        self._switch.leave(self)
        self._transport.write(bytes(self._backlog))
        self._transport.close()
        self._end = asyncio.get_running_loop().call_later(FAREWELL, self._transport.abort)

    def _write(self, data: bytes) -> None:
        if self._transport.is_closing():
            return
        if self._takes:
            self._transport.write(data)
        else:
            self._backlog += data
            self._check(len(self._backlog))

    def _check(self, waiting: int) -> None:
        if waiting > MOST_WAITING:
            log.warning("%s does not read what is on %s: dropped", self.name, self.bus)
            self._switch.leave(self)
            self._transport.abort()

    def _obey(self, text: str) -> None:
        commands = self._commands[self._stage]
        if not (obey := commands.get(text.partition(" ")[0])):
            raise Refused(f"unknown command, there is {', '.join(commands)}")
        obey(self, text)

    def _open(self, text: str) -> None:
        if not (match := OPEN.fullmatch(text)):
            raise Refused("the name of a bus is 1 to 16 letters, digits and _.-")
        self.bus, self._stage = match[1], Stage.OPENED
        self._write(element("ok"))

    def _own(self, text: str) -> None:
        """It has nodes with these ids: a second one with one of them would not do any good."""
        node_ids = read_owning(text)
        if (owned := self._switch.owner(self, node_ids)) is not None:
            raise Refused(f"node {owned[0]} is on {self.bus} already, of {owned[1]}")
        self.node_ids |= node_ids
        self._write(element("ok"))

    def _join(self, text: str) -> None:
        """Frames are kept back for a moment: python-can has to read this answer all by itself."""
        self._stage, self._settling = Stage.JOINED, bytearray()
        self._write(element("ok"))
        self._switch.join(self)
        asyncio.get_running_loop().call_later(SETTLING, self._settle)
        log.info("%s is on %s", self.name, self.bus)

    def _send(self, text: str) -> None:
        self._sent.append(delivered(read_sent(text), time.time()))

    def _pass_on(self) -> None:
        """What it has sent in a turn goes out in one piece: who floods a bus costs others less."""
        if self._sent:
            data, self._sent = b"".join(self._sent), []
            self._switch.send(self, data)

    def _echo(self, text: str) -> None:
        self._pass_on()
        self._write(element("echo"))

    def _settle(self) -> None:
        held, self._settling = self._settling, None
        if held:
            self._write(bytes(held))

    def _hurry(self) -> None:
        if self._stage is not Stage.JOINED and self in self._switch.clients:
            self._refuse(f"on no bus within {HANDSHAKE:.0f} s")

    def _refuse(self, why: str) -> None:
        log.warning("%s refused: %s", self.name, why)
        self._write(element(f"error {why}"))
        self.hang_up()

    _commands: ClassVar[Mapping[Stage, Mapping[str, Callable[["Connection", str], None]]]] = {
        Stage.GREETED: {"open": _open},
        Stage.OPENED: {"rawmode": _join, "own": _own, "echo": _echo},
        Stage.JOINED: {"send": _send, "sendrtr": _send, "echo": _echo},
    }
