"""Everything that happens on the bus and at the nodes, in its order, for whoever watches."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import NamedTuple

from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.scenario.matchers import Changed, Happening, Sent
from canopen_twins.scenario.player.writes import Writes
from canopen_twins.slave.service import State

Ear = Callable[[Happening], None]


class Position(NamedTuple):
    """Where in the order of what happens: behind so many things of one microsecond."""

    tick: int
    passed: int


class Happenings:
    """Keeps what has happened at this microsecond, so that who comes late hears it too.

    States and writes cost something with every frame, so they are followed only at nodes that
    somebody attends to.
    """

    def __init__(self, nodes: Mapping[str, Node], clock: Clock) -> None:
        self._clock = clock
        self._senders = {node.wire.name: node for node in nodes.values()}
        self._ears: list[Ear] = []
        self._moment = clock.ticks
        self._present: list[Happening] = []
        self._changes: list[Changed] = []
        self._writes: dict[int, Writes] = {}

    def attend_to_states(self, node: Node) -> None:
        """Follow the NMT states of a node from now on."""
        node.listeners.append(partial(self._on_state, node))

    def attend_to_writes(self, node: Node) -> None:
        """Follow what the master writes to a node from now on."""
        self._writes.setdefault(id(node), Writes(node))

    def listen(self, ear: Ear) -> None:
        """Tell somebody what happens from now on."""
        self._ears.append(ear)

    def ignore(self, ear: Ear) -> None:
        """Tell him no more."""
        self._ears.remove(ear)

    @property
    def position(self) -> Position:
        """Behind everything that has happened so far."""
        self._renew()
        return Position(self._moment, len(self._present))

    def since(self, position: Position) -> Sequence[Happening]:
        """What has happened at this microsecond, as far as it is behind a position."""
        self._renew()
        return self._present[position.passed if position.tick == self._moment else 0 :]

    def hear(self, frame: Frame, sender: str) -> None:
        """Take a frame from the bus, after the nodes have had it."""
        sent = Sent(frame, self._senders.get(sender))
        if self._changes or self._writes:
            self._hear_all(sent)
        else:
            self._happen((sent,))

    def _hear_all(self, sent: Sent) -> None:
        self._flush(lambda change: change.node is sent.node)
        written = (writes.follow(sent) for writes in self._writes.values())
        self._happen((sent, *chain.from_iterable(written)))
        self._flush()

    def _on_state(self, node: Node, state: State) -> None:
        """What a node does follows its new state; what others send has been the cause."""
        self._changes.append(Changed(node, state))
        self._clock.at_tick(self._clock.ticks, self._flush)

    def _flush(self, which: Callable[[Changed], bool] = lambda change: True) -> None:
        changes, self._changes = self._changes, []
        for change in changes:
            if which(change):
                self._happen((change,))
            else:
                self._changes.append(change)

    def _happen(self, together: Sequence[Happening]) -> None:
        """A frame and what it writes are one: who begins to listen with it begins behind it."""
        if self._moment != self._clock.ticks:
            self._renew()
        self._present += together
        if self._ears:
            ears = tuple(self._ears)
            for one in together:
                for ear in ears:
                    ear(one)

    def _renew(self) -> None:
        if self._moment != self._clock.ticks:
            self._moment = self._clock.ticks
            self._present.clear()
