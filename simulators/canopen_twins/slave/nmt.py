"""Network management (CiA 301, 7.2.8): NMT slave, boot-up message, heartbeats sent and heard."""

from collections.abc import Callable, Mapping
from enum import IntEnum
from functools import partial

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import NODE_IDS
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

ALL_NODES = 0
TARGET: Mapping[int, State] = {
    0x01: State.OPERATIONAL,
    0x02: State.STOPPED,
    0x80: State.PRE_OPERATIONAL,
}


class Reset(IntEnum):
    """Command specifiers that end in Initialisation."""

    NODE = 0x81
    COMMUNICATION = 0x82


RESETS: Mapping[int, Reset] = {reset.value: reset for reset in Reset}


class Nmt(Service):
    """`state` and `reset` are read by the node after every frame.

    A device that enters a state by itself sets `state` as the master would.
    """

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self.state = State.PRE_OPERATIONAL
        self.reset: Reset | None = None

    def listen(self) -> Listening:
        """Commands of the NMT master."""
        yield (identifiers.NMT, False), self.on_command

    def on_state(self, state: State) -> None:
        """Kept for whoever asks afterwards why something was not answered."""
        self.slave.wire.events.add_state(state)

    def on_command(self, frame: Frame) -> None:
        """Obey if the length is right and the command meant for this node or for all."""
        if len(frame.data) not in self.slave.profile.nmt_lengths:
            return
        command, target = frame.data[:2]
        if target not in (ALL_NODES, self.slave.node_id):
            return
        if command in TARGET:
            self.state = TARGET[command]
        elif command in RESETS:
            self.state, self.reset = State.INITIALISING, RESETS[command]

    def boot_up(self) -> None:
        """Announce that initialisation is over."""
        self.slave.send(Frame(identifiers.heartbeat(self.slave.node_id), BOOT_UP))


BOOT_UP = b"\0"
STATE_BYTE = {
    State.STOPPED: 0x04,
    State.OPERATIONAL: 0x05,
    State.PRE_OPERATIONAL: 0x7F,
}
"""What a heartbeat shows."""


class HeartbeatProducer(Service):
    """Sends the state every 0x1017 ms, the first one a period after the write."""

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self._timer: Timer | None = None
        self._state = State.PRE_OPERATIONAL

    @property
    def objects(self) -> Mapping[Address, Object]:
        """A new period acts at once."""
        return {(0x1017, 0): Object(write=self._on_write)} if self.slave.has(0x1017) else {}

    def start(self) -> None:
        """Begin with the period the dictionary has after a reset."""
        if self.slave.has(0x1017):
            self._start(self.slave.number(0x1017))

    def on_state(self, state: State) -> None:
        """From now on this state is shown."""
        self._state = state

    def _on_write(self, milliseconds: int) -> None:
        self._start(milliseconds)
        if milliseconds and self.slave.profile.first_heartbeat_at_once:
            self._beat()

    def _start(self, milliseconds: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None
        if milliseconds:
            period = self.slave.profile.heartbeat_period(milliseconds)
            self._timer = self.slave.clock.every(period, self._beat)

    def _beat(self) -> None:
        can_id = identifiers.heartbeat(self.slave.node_id)
        self.slave.send(Frame(can_id, bytes([STATE_BYTE[self._state]])))


class HeartbeatConsumer(Service):
    """Watches the nodes that 0x1016 names, each from its first heartbeat on (CiA 301, 7.2.8.2.2).

    Whoever is told hears of a node with its id and whether it is alive.
    """

    def __init__(self, slave: Slave, tell: Callable[[int, bool], None]) -> None:
        super().__init__(slave)
        self._tell = tell
        self._watched: dict[int, Timer] = {}
        self._lost: set[int] = set()

    @property
    def objects(self) -> Mapping[Address, Object]:
        """A node has one time at most."""
        entries = self.slave.entries.get(0x1016, {})
        return {(0x1016, sub): Object(write=partial(self._check, sub)) for sub in entries if sub}

    def listen(self) -> Listening:
        """The heartbeats of every node with an id and a time."""
        watched = dict(self._named.values())
        for node_id in [known for known in self._watched if known not in watched]:
            self._watched.pop(node_id).cancel()
        for node_id, time in watched.items():
            yield (
                (identifiers.heartbeat(node_id), False),
                partial(self._on_heartbeat, node_id, time),
            )

    @property
    def _named(self) -> Mapping[int, tuple[int, float]]:
        """Node id and time in seconds of every entry that is in use, by sub-index."""
        subindices = [sub for sub in self.slave.entries.get(0x1016, {}) if sub]
        entries = {sub: _consumed(self.slave.number(0x1016, sub)) for sub in subindices}
        return {sub: entry for sub, entry in entries.items() if entry is not None}

    def _check(self, subindex: int, value: int) -> None:
        new = _consumed(value)
        others = [node_id for sub, (node_id, _) in self._named.items() if sub != subindex]
        if new is not None and new[0] in others:
            raise Rejected("the node has a time already", Abort.INCOMPATIBLE)  # 7.5.2.19

    def _on_heartbeat(self, node_id: int, time: float, frame: Frame) -> None:
        if len(frame.data) != 1:
            return
        if node_id in self._watched:
            self._watched[node_id].cancel()
        self._watched[node_id] = self.slave.clock.after(time, partial(self._on_silence, node_id))
        if node_id in self._lost:
            self._lost.remove(node_id)
            self._tell(node_id, True)

    def _on_silence(self, node_id: int) -> None:
        self._lost.add(node_id)
        self._tell(node_id, False)


def _consumed(value: int) -> tuple[int, float] | None:
    """Node id and time in seconds of an entry of 0x1016, if it is in use."""
    node_id, milliseconds = value >> 16 & 0xFF, value & 0xFFFF
    in_use = node_id in NODE_IDS and milliseconds
    return (node_id, milliseconds / 1000) if in_use else None
