"""What happens on the bus and at the nodes, in order: frames, writes of the master, NMT states."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import NamedTuple

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address, Ccs, Scs, Sub
from canopen_twins.device.node import Node
from canopen_twins.slave.pdo import COB_ID, Mapped, carried
from canopen_twins.slave.service import State
from canopen_twins.slave.slave import Slave


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


BusEvent = Sent | Wrote | Changed
Listener = Callable[[BusEvent], None]
Source = tuple[type[BusEvent], Node | None]
"""A kind of events, and whose: most listeners want those of one, and there are many of both."""


class Position(NamedTuple):
    """Where in the order of events: behind so many of one microsecond."""

    tick: int
    passed: int


WHOLE_MOMENT = Position(-1, 0)
"""In front of all events of the microsecond, whichever it is."""


class BusEvents:
    """Keeps the events of this microsecond, so that who comes late hears them too.

    States and writes cost something with every frame, so they are followed only at nodes where
    somebody asks for them.
    """

    def __init__(self, nodes: Mapping[str, Node], clock: Clock) -> None:
        self.nodes = nodes
        """Those of the scenario, by its names."""
        self.clock = clock
        self._senders = {node.wire.name: node for node in nodes.values()}
        self._listeners: dict[Source, list[Listener]] = {}
        self._moment = clock.ticks
        self._present: list[BusEvent] = []
        self._changes: list[Changed] = []
        self._states: dict[str, Callable[[State], None]] = {}  # who follows them, by node
        self._writes: dict[str, MasterWrites] = {}

    def follow_states(self, name: str) -> None:
        """NMT states of a node are events from now on."""
        if name not in self._states:
            node = self.nodes[name]
            self._states[name] = partial(self._on_state, node)
            node.listeners.append(self._states[name])

    def follow_writes(self, name: str) -> None:
        """What the master writes to a node is an event from now on."""
        self._writes.setdefault(name, MasterWrites(self.nodes[name]))

    def leave(self) -> None:
        """Follow no states any more."""
        for name, listener in self._states.items():
            self.nodes[name].listeners.remove(listener)
        self._states.clear()

    @property
    def sources(self) -> Collection[Source]:
        """All that there are."""
        kinds: Sequence[type[BusEvent]] = (Sent, Wrote, Changed)
        return [(Sent, None), *((kind, node) for node in self.nodes.values() for kind in kinds)]

    def listen(self, listener: Listener, sources: Iterable[Source]) -> None:
        """Tell somebody every event of some sources from now on."""
        for source in sources:
            self._listeners.setdefault(source, []).append(listener)

    def ignore(self, listener: Listener, sources: Iterable[Source]) -> None:
        """Tell him no more."""
        for source in sources:
            self._listeners[source].remove(listener)

    @property
    def position(self) -> Position:
        """Behind all events so far."""
        self._renew()
        return Position(self._moment, len(self._present))

    def since(self, position: Position) -> Sequence[BusEvent]:
        """The events of this microsecond, as far as they are behind a position."""
        self._renew()
        return self._present[position.passed if position.tick == self._moment else 0 :]

    def hear(self, frame: Frame, sender: str) -> None:
        """Take a frame from the bus, after the nodes have had it."""
        sent = Sent(frame, self._senders.get(sender))
        if not self._changes and not self._writes:
            self._tell((sent,))
            return
        self._tell_changes(lambda change: change.node is sent.node)
        written = (writes.follow(sent) for writes in self._writes.values())
        self._tell((sent, *chain.from_iterable(written)))
        self._tell_changes()

    def _on_state(self, node: Node, state: State) -> None:
        """What a node does follows its new state; what others send has been the cause."""
        self._changes.append(Changed(node, state))
        self.clock.at_tick(self.clock.ticks, self._tell_changes)

    def _tell_changes(self, which: Callable[[Changed], bool] = lambda change: True) -> None:
        changes, self._changes = self._changes, []
        for change in changes:
            if which(change):
                self._tell((change,))
            else:
                self._changes.append(change)

    def _tell(self, together: Sequence[BusEvent]) -> None:
        """A frame and what it writes are one: who begins to listen with it begins behind it."""
        if self._moment != self.clock.ticks:
            self._renew()
        self._present += together
        heard = [(each, tuple(self._listeners.get(_source(each), ()))) for each in together]
        for event, listeners in heard:
            for listener in listeners:
                listener(event)

    def _renew(self) -> None:
        if self._moment != self.clock.ticks:
            self._moment = self.clock.ticks
            self._present.clear()


def _source(event: BusEvent) -> Source:
    return type(event), event.node


RPDOS, MAPPING = range(0x1400, 0x1600), 0x0200  # and the distance to a mapping record

Parts = list[tuple[Address, Mapped]]


class MasterWrites:
    """What the master writes to one node, by SDO and with RPDOs, as seen from the bus.

    Both count in every NMT state; while the node is silent, requests alone.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._downloads = Downloads()
        self._version: tuple[Slave, int] | None = None
        self._rpdos: Mapping[int, Parts] = {}

    def follow(self, sent: Sent) -> Iterator[Wrote]:
        """Take a frame; what has been written with it."""
        frame, node = sent.frame, self._node
        if frame.remote or frame.extended:
            return
        is_sdo = len(frame.data) == sdo.LENGTH
        if sent.node is node:
            if frame.can_id == identifiers.sdo_answer(node.node_id) and is_sdo:
                self._downloads.answer(frame.data)
        elif sent.node is None and frame.can_id == identifiers.sdo_request(node.node_id):
            if is_sdo:
                for address, data, sized in self._downloads.ask(frame.data):
                    yield Wrote(node, address, data, sized)
        elif sent.node is None:
            yield from self._mapped(frame)

    def _mapped(self, frame: Frame) -> Iterator[Wrote]:
        slave = self._node.slave
        version = None if slave is None else (slave, slave.changes)
        if version != self._version:
            self._version = version
            self._rpdos = {} if slave is None else _rpdos(slave)
        for address, part in self._rpdos.get(frame.can_id, ()):
            if part.end <= 8 * len(frame.data):
                yield Wrote(self._node, address, part.value(frame.data))


def _rpdos(slave: Slave) -> Mapping[int, Parts]:
    """What every RPDO that is on brings, by its identifier."""
    rpdos: dict[int, Parts] = {}
    for index in [each for each in slave.object_dictionary if each in RPDOS]:
        if slave.has(index, COB_ID) and slave.has(index + MAPPING):
            cob_id = slave.number(index, COB_ID)
            if not cob_id & identifiers.INVALID:
                parts = carried(slave, index + MAPPING)
                rpdos.setdefault(cob_id & identifiers.CAN_ID, []).extend(
                    (part.entry.address, part) for part in parts if part.entry is not None
                )
    return rpdos


class Downloaded(NamedTuple):
    """A value that has been written."""

    address: Address
    data: bytes
    sized: bool = True
    """Whether all of the bytes count."""


class Downloads:
    """SDO downloads of one client as seen from the bus, whatever its server makes of them."""

    def __init__(self) -> None:
        self._open: int | None = None
        """How the download that is under way has begun, if it takes more than one frame."""
        self._address: Address = (0, 0)
        self._data = b""
        self._toggle = 0
        self._block: list[bytes] | None = None  # every frame is a segment of it

    def ask(self, data: bytes) -> Iterator[Downloaded]:
        """The client has sent a request; what is complete with it."""
        specifier = sdo.specifier(data)
        if self._block is not None and not sdo.is_abort(data):
            if len(self._block) < sdo.LONGEST_BLOCK:
                self._block.append(data)
        elif specifier == Ccs.DOWNLOAD_SEGMENT and self._open == Ccs.DOWNLOAD:
            if data[0] & sdo.TOGGLE == self._toggle:  # another one comes for the second time
                self._toggle ^= sdo.TOGGLE
                self._data += sdo.segment_part(data)
                if data[0] & sdo.LAST:
                    yield self._complete(self._data)
        elif specifier == self._open == Ccs.BLOCK_DOWNLOAD and data[0] & Sub.END:
            yield self._complete(sdo.block_value(data, self._data))
        else:
            yield from self._initiate(data)

    def answer(self, data: bytes) -> None:
        """The server has answered; what it does not confirm of a block will come again."""
        if self._open != Ccs.BLOCK_DOWNLOAD:
            return
        if sdo.is_abort(data):
            self._open = self._block = None
        elif sdo.specifier(data) == Scs.BLOCK_DOWNLOAD:
            if data[0] & Sub.START == Sub.CONFIRM:
                self._confirm(self._block or [], data[1])
            else:
                self._block = self._block or []

    def _confirm(self, block: list[bytes], count: int) -> None:
        numbered = enumerate(block, 1)
        had = [data for place, data in numbered if sdo.block_number(data) == place][:count]
        self._data += b"".join(data[1:] for data in had)
        is_last = any(data[0] & sdo.LAST_OF_BLOCKS for data in had)
        self._block = None if is_last else []

    def _complete(self, data: bytes) -> Downloaded:
        self._open = None
        return Downloaded(self._address, data)

    def _initiate(self, data: bytes) -> Iterator[Downloaded]:
        self._open = self._block = None
        self._address, self._data, self._toggle = sdo.address(data), b"", 0
        specifier = sdo.specifier(data)
        if specifier == Ccs.BLOCK_DOWNLOAD and not data[0] & Sub.END:
            self._open = Ccs.BLOCK_DOWNLOAD
        elif specifier == Ccs.DOWNLOAD and not sdo.is_expedited(data):
            self._open = Ccs.DOWNLOAD
        elif specifier == Ccs.DOWNLOAD:
            yield Downloaded(self._address, sdo.value(data), sdo.size(data) is not None)
