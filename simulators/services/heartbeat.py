"""Heartbeat: the producer on the clock, and the consumer of other nodes' heartbeats (0x1016)."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from simulators.clock import Timer
from simulators.objects import Address, Object
from simulators.services import Listening, Service, State
from simulators.slave import Slave
from simulators.wire import Frame

STATE_BYTE = {
    State.INITIALISING: 0x00,
    State.STOPPED: 0x04,
    State.OPERATIONAL: 0x05,
    State.PRE_OPERATIONAL: 0x7F,
}


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
        self.slave.wire.put(Frame(0x700 + self.slave.node_id, bytes([STATE_BYTE[self._state]])))


class HeartbeatConsumer(Service):
    """Watches the nodes that 0x1016 names, each from its first heartbeat on (CiA 301, 7.2.8.2.2).

    Whoever is told hears of a node with its id and whether it is alive.
    """

    def __init__(self, slave: Slave, tell: Callable[[int, bool], None]) -> None:
        super().__init__(slave)
        self._tell = tell
        self._watched: dict[int, Timer] = {}
        self._lost: set[int] = set()

    def listen(self) -> Listening:
        """The heartbeats of every node with an id and a time."""
        watched = dict(self._named())
        for node_id in self._watched.keys() - watched.keys():
            self._watched.pop(node_id).cancel()
        for node_id, time in watched.items():
            yield (0x700 + node_id, False), partial(self._on_heartbeat, node_id, time)

    def _named(self) -> Iterator[tuple[int, float]]:
        entries = self.slave.entries.get(0x1016, {})
        for value in (self.slave.number(0x1016, sub) for sub in entries if sub):
            node_id, milliseconds = value >> 16 & 0x7F, value & 0xFFFF
            if node_id and milliseconds:
                yield node_id, milliseconds / 1000

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
