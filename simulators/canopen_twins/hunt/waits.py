"""How long a master waits for the answer to an SDO request, learnt from runs in which none came.

An answer that is late by that is taken for another one by a master that does not look: by any other
time it comes when nobody waits, or when all is still well. So a hunt tries just these.
"""

from __future__ import annotations

from statistics import median_low
from typing import NamedTuple

from canopen_twins.bus import sdo
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.slave.object import Address

NEXT = 2
"""Requests after the one without an answer: the first may be the same again, the second is not."""
DIGITS = 4  # of seconds


class Wait(NamedTuple):
    """What a master has asked for in vain, and when its next requests have come."""

    node: str
    address: Address | None
    """None: of whatever it asks for."""
    access: str
    request: int
    """Which of the next ones, counted from 1."""
    seconds: float
    """By how much an answer is late that comes between that one and its own answer."""
    answer: float
    """How many seconds an answer of the node takes."""

    def is_for(self, address: Address | None, access: str) -> bool:
        """Whether an access may be waited for so long."""
        return self.address is None or (self.address, self.access) == (address, access)


class Lost(NamedTuple):
    """A request to which no answer has come."""

    tick: int
    address: Address
    access: str


class Server:
    """The requests to one node."""

    def __init__(self) -> None:
        self.gaps: dict[tuple[Address, str, int], int] = {}
        """From a request without an answer to those after it, in microseconds: the shortest."""
        self.answers: list[int] = []
        self._conversation = sdo.Conversation()
        self._asked: Lost | None = None
        self._lost: Lost | None = None
        self._next = 0

    def ask(self, data: bytes, tick: int) -> None:
        """The master has sent a request; with an abort it asks for nothing."""
        self._conversation.ask(data)
        address = self._conversation.address
        if address is None:
            return
        if self._asked is not None:
            self._lost, self._next = self._asked, 0
        if self._lost is not None and self._next < NEXT:
            self._next += 1
            key = self._lost.address, self._lost.access, self._next
            gap = tick - self._lost.tick
            self.gaps[key] = min(gap, self.gaps.get(key, gap))
        self._asked = Lost(tick, address, self._conversation.access)

    def answer(self, data: bytes, tick: int) -> None:
        """The node has sent an answer."""
        self._conversation.answer(data)
        if self._asked is not None:
            self.answers.append(tick - self._asked.tick)
            self._asked = None


class WaitRecorder:
    """Takes down the requests of a run."""

    def __init__(self) -> None:
        self._servers: dict[str, Server] = {}

    def ask(self, node: str, data: bytes, tick: int) -> None:
        """The master has sent an SDO request to a node."""
        self._servers.setdefault(node, Server()).ask(data, tick)

    def answer(self, node: str, data: bytes, tick: int) -> None:
        """A node has sent an SDO answer."""
        if node in self._servers:
            self._servers[node].answer(data, tick)

    @property
    def waits(self) -> tuple[Wait, ...]:
        """What they show; a request that waited for nothing, as of another thread, shows none."""
        return tuple(
            Wait(node, *key, _seconds(gap - answer // 2), _seconds(answer))
            for node, server in self._servers.items()
            for answer in [median_low(server.answers or [0])]
            for key, gap in server.gaps.items()
            if gap > 2 * answer
        )


def _seconds(ticks: int) -> float:
    return round(ticks / MICROSECONDS, DIGITS)
