"""Error control (CiA 301, 7.2.8.2): heartbeats sent and heard, node guarding, what errors do."""

from collections.abc import Callable, Mapping
from functools import partial

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import NODE_IDS
from canopen_twins.bus.wire import ErrorState
from canopen_twins.slave.nmt import BOOT_UP, STATE_BYTE, Nmt
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

NOT_HEARD, ERROR_PASSIVE, RECOVERED = 0x8130, 0x8120, 0x8140  # emergency error codes
IS_PASSIVE = "the CAN controller is error passive"
HAS_RECOVERED = "the CAN controller was bus off"
NOT_GUARDED = "the NMT master does not guard any more"
AFTER_ERROR = range(3)  # 0x1029: Pre-operational, no change, Stopped


class CommunicationErrors(Service):
    """Tells errors of communication, and does what 0x1029 wants of them (7.5.2.25).

    The state is left after the emergency: in Stopped there would be none.
    """

    def __init__(self, slave: Slave, nmt: Nmt) -> None:
        super().__init__(slave)
        self._nmt = nmt
        self._controller = slave.wire.error_state

    @property
    def objects(self) -> Mapping[Address, Object]:
        """What an error of communication does."""
        address = (0x1029, 1)
        return {address: Object(write=self._check)} if self.slave.has(*address) else {}

    @property
    def eventful(self) -> bool:
        """A CAN controller changes its state unasked."""
        return self.slave.profile.tells_bus_errors

    def publish(self) -> None:
        """Follow the CAN controller."""
        before, self._controller = self._controller, self.slave.wire.error_state
        if before is self._controller:
            return
        if self._controller is ErrorState.PASSIVE:
            self.slave.errors[IS_PASSIVE] = ERROR_PASSIVE
        else:
            self.end(IS_PASSIVE)
        if self._controller is ErrorState.BUS_OFF:
            self._react()
        elif before is ErrorState.BUS_OFF:  # over when it can be told: it comes and goes
            self.slave.errors[HAS_RECOVERED] = RECOVERED
            self.slave.clock.after(0, partial(self.end, HAS_RECOVERED))

    def begin(self, why: str, code: int) -> None:
        """An error that lasts, its words and its emergency error code."""
        self.slave.errors[why] = code
        self._react()

    def end(self, why: str) -> None:
        """It is over, if it has begun."""
        self.slave.errors.pop(why, None)

    def _react(self) -> None:
        self.slave.clock.after(0, self._leave)

    def _leave(self) -> None:
        does = self.slave.number(0x1029, 1) if self.slave.has(0x1029, 1) else 0
        if does == 0 and self._nmt.state is State.OPERATIONAL:
            self._nmt.state = State.PRE_OPERATIONAL
        elif does == 2:
            self._nmt.state = State.STOPPED

    def _check(self, value: int) -> None:
        if value not in AFTER_ERROR:
            raise Rejected(f"{value} is no behaviour: 0, 1 or 2")


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
            self._timer = self.slave.clock.every_alone(period, self._beat)

    def _beat(self) -> None:
        can_id = identifiers.heartbeat(self.slave.node_id)
        self.slave.send(Frame(can_id, bytes([STATE_BYTE[self._state]])))


class HeartbeatConsumer(Service):
    """Watches the nodes that 0x1016 names, each from its first heartbeat on (CiA 301, 7.2.8.2.2).

    Whoever is told hears of a node with its id and whether it is alive. Where the profile says so
    a silent node is an error of communication, too.
    """

    def __init__(
        self, slave: Slave, errors: CommunicationErrors, tell: Callable[[int, bool], None]
    ) -> None:
        super().__init__(slave)
        self._errors = errors
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
            self._errors.end(_silent(node_id))
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
        if frame.data == BOOT_UP and node_id not in {*self._watched, *self._lost}:
            return  # no heartbeat yet
        if node_id in self._watched:
            self._watched[node_id].cancel()
        self._watched[node_id] = self.slave.clock.after(time, partial(self._on_silence, node_id))
        if node_id in self._lost:
            self._lost.remove(node_id)
            self._errors.end(_silent(node_id))
            self._tell(node_id, True)

    def _on_silence(self, node_id: int) -> None:
        self._lost.add(node_id)
        if self.slave.profile.tells_bus_errors:
            self._errors.begin(_silent(node_id), NOT_HEARD)
        self._tell(node_id, False)


def _silent(node_id: int) -> str:
    return f"node {node_id} is silent"


def _consumed(value: int) -> tuple[int, float] | None:
    """Node id and time in seconds of an entry of 0x1016, if it is in use."""
    node_id, milliseconds = value >> 16 & 0xFF, value & 0xFFFF
    in_use = node_id in NODE_IDS and milliseconds
    return (node_id, milliseconds / 1000) if in_use else None


TOGGLE = 0x80


class NodeGuarding(Service):
    """Answers remote requests with state and toggle bit, and watches that they come (7.2.8.2.2.1).

    Life guarding begins with the first request. Heartbeats take its place while there are any.
    """

    def __init__(self, slave: Slave, errors: CommunicationErrors) -> None:
        super().__init__(slave)
        self._errors = errors
        self._state = State.PRE_OPERATIONAL
        self._toggle = 0
        self._life = 0.0  # s
        self._timer: Timer | None = None

    def listen(self) -> Listening:
        """Remote requests for the heartbeat, if 0x100C is there and 0x1017 is 0."""
        life = self._number(0x100C) * self._number(0x100D) / 1000
        replaced = bool(self._number(0x1017))
        if replaced or life != self._life:
            self._stop()
        self._life = life
        if self.slave.has(0x100C) and not replaced:
            yield (identifiers.heartbeat(self.slave.node_id), True), self.on_request

    def on_state(self, state: State) -> None:
        """From now on this state is shown."""
        self._state = state

    def on_request(self, frame: Frame) -> None:
        """The master guards."""
        self._stop()
        if self._life:
            self._timer = self.slave.clock.after(self._life, self._on_silence)
        data = bytes([self._toggle | STATE_BYTE[self._state]])
        self._toggle ^= TOGGLE
        self.slave.send(Frame(frame.can_id, data))

    def _stop(self) -> None:
        self._errors.end(NOT_GUARDED)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _on_silence(self) -> None:
        self._timer = None
        self._errors.begin(NOT_GUARDED, NOT_HEARD)

    def _number(self, index: int) -> int:
        return self.slave.number(index) if self.slave.has(index) else 0
