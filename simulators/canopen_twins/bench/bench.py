"""A test bench: twins and a canopen master in one process, in simulated time, without a thread."""

from collections.abc import Callable, Mapping, Sequence
from math import inf
from threading import get_ident
from typing import Any, Self

import canopen
from canopen.nmt import NmtError, NmtMaster

from canopen_twins import devices
from canopen_twins.bench.limits import OutOfTime, SimulatedTimeError, Standstill, place_of
from canopen_twins.bench.twin import ORDERS, QUESTIONS, Twin
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import Cob, classify
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.bus.wire import PeriodicFrame
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError

MOST_SENT = 250_000  # frames of the master at one moment


class BenchTwin(Twin):
    """One twin on a bench, as a test sees it: the device itself, and a master's view of it."""

    def __init__(
        self, nodes: Sequence[Node], segment: Segment[Node], master: canopen.Network
    ) -> None:
        self._nodes = nodes
        self.segment = segment
        self.master = master

    @property
    def node(self) -> Node:
        """What is on the bus of it.

        Raises:
            LookupError: this is a bench with several; take them by name.
        """
        if len(self._nodes) != 1:
            first = self._nodes[0].wire.name
            raise LookupError(f"several twins: say which, such as bench[{first!r}]")
        return self._nodes[0]

    @property
    def name(self) -> str:
        """As it is called on the bench."""
        return self.node.wire.name

    def order(self, word: str, *arguments: Any) -> None:
        """At once: a bench stands still between two calls."""
        ORDERS[word](self.node, *arguments)
        self.segment.deliver()

    def ask(self, word: str, *arguments: Any) -> Any:
        """At once, too."""
        return QUESTIONS[word](self.node, *arguments)

    @property
    def device(self) -> Any:
        """The device itself as it is at this moment.

        Looking sends nothing. What is done to it by hand counts before the next frame from outside,
        and before time moves.
        """
        self.segment.touch(self.node.settle)
        return self.node.look()

    @property
    def remote(self) -> canopen.RemoteNode:
        """The master's view of the node, with the dictionary of its EDS."""
        node_id = self.node.node_id
        if node_id not in self.master:
            added = self.master.add_node(node_id, self.node.device.dictionary())
            added.sdo.RESPONSE_TIMEOUT = 0.0  # the answer is there already, or never comes
        remote = self.master[node_id]
        assert isinstance(remote, canopen.RemoteNode)
        return remote

    @property
    def sdo(self) -> Any:
        """SDO access by a real client: `sdo["Run command"].raw = 1`."""
        return self.remote.sdo


class Bench(BenchTwin):
    """One or several twins with power on. Times are in seconds of the bench's own clock.

    `Bench("topcon", node_id=5, load="resistor 4")` has one twin, and is the handle on it.
    `Bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})` has several: `bench["left"].sdo`.
    Where a name stands, the path of an EDS file or a class may stand: `Bench("drive.eds")`.

    Raises:
        UserError: an unknown device or setting, or two nodes with one id.
    """

    def __init__(self, device: devices.What | Mapping[str, Device], **settings: object) -> None:
        if not isinstance(device, Mapping):
            device = {devices.name_of(device): devices.create(device, **settings)}
        elif settings:
            raise UserError(
                f"which device of several has {', '.join(settings)}? Give it to that one"
            )
        from canopen_twins.faults import connect  # noqa: PLC0415 - who has no bench needs no faults

        segment: Segment[Node] = Segment()
        nodes = [connect(segment, each, name) for name, each in device.items()]
        super().__init__(nodes, segment, Master(segment))
        self.twins = {node.wire.name: BenchTwin([node], segment, self.master) for node in nodes}
        self.clock = segment.clock
        self.trace: list[Record] = []
        segment.listeners.append(self._record)
        self._begin()

    @classmethod
    def of(cls, nodes: Mapping[str, tuple[devices.What, int] | Device]) -> Self:
        """Several nodes on one bus and one clock: for each name a device and its node id."""
        return cls({name: _device(what) for name, what in nodes.items()})

    def _begin(self) -> None:
        for twin in self.twins.values():
            twin.power_on()

    def __getitem__(self, name: str) -> BenchTwin:
        return self.twins[name]

    @property
    def twin(self) -> BenchTwin:
        """The only twin of the bench.

        Raises:
            LookupError: there are several; take them by name.
        """
        return self.twins[self.name]

    def send(self, text: str) -> list[str]:
        """Put one frame on the bus; what the twins send before time moves.

        Raises:
            UserError: the text is no frame in the notation of cansend.
        """
        return self.put(Frame.parse(text))

    def put(self, frame: Frame) -> list[str]:
        """The same for a frame that is one already."""
        start = len(self.trace)
        self.segment.send(frame)
        return self._sent(start)

    def run(self, seconds: float) -> list[str]:
        """Let simulated time pass; what the twins send meanwhile.

        Raises:
            UserError: it is no number of seconds, or less than none.
        """
        if not isinstance(seconds, (int, float)) or not 0 <= seconds < inf:
            told = "write seconds as a number" if isinstance(seconds, str) else "time only goes on"
            raise UserError(f"run({seconds!r}): {told}, such as run(0.5)")
        start = len(self.trace)
        self.segment.advance(seconds)
        return self._sent(start)

    @property
    def sent(self) -> list[str]:
        """Everything the twins have sent so far."""
        return self._sent(0)

    def _record(self, frame: Frame, sender: str) -> None:
        self.trace.append(Record(self.clock.now, frame, sender))

    def _sent(self, start: int) -> list[str]:
        records: Sequence[Record] = self.trace[start:]
        return [str(record.frame) for record in records if record.sender in self.twins]


def _device(what: tuple[devices.What, int] | Device) -> Device:
    if isinstance(what, Device):
        return what
    name, node_id = what
    return devices.create(name, node_id=node_id)


class NmtOfBench(NmtMaster):
    """Waits in simulated time, and knows what has come at this very moment: answers already have.

    It takes the place of the one that canopen makes for a node.
    """

    def __init__(self, made: NmtMaster, segment: Segment[Node]) -> None:
        super().__init__(made.id)
        vars(self).update(vars(made))
        self._segment = segment
        self._heard: dict[bool, float] = {}  # when last, by whether it was a boot-up

    def on_heartbeat(self, can_id: int, data: bytearray, timestamp: float) -> None:
        """What canopen calls for a heartbeat or a boot-up."""
        super().on_heartbeat(can_id, data, timestamp)  # type: ignore[no-untyped-call]
        self._heard[self._state_received == 0] = self._segment.clock.now

    def send_command(self, code: int) -> None:
        """What was heard before a command is no answer to it."""
        self._heard.clear()
        super().send_command(code)

    def wait_for_bootup(self, timeout: float = 10) -> None:
        """Let time pass until a boot-up message comes, at most so many seconds of the bench.

        Raises:
            canopen.nmt.NmtError: none has come.
        """
        if not self._wait(timeout, lambda: True in self._heard):
            raise NmtError("Timeout waiting for boot-up message")

    def wait_for_heartbeat(self, timeout: float = 10) -> str:
        """The same for a heartbeat; the state that it told.

        Raises:
            canopen.nmt.NmtError: none has come.
        """
        if not self._wait(timeout, lambda: bool(self._heard)):
            raise NmtError("No boot-up or heartbeat received")
        return str(self.state)

    def _wait(self, timeout: float, is_over: Callable[[], bool]) -> bool:
        """Whether it is over in time; each thing that was heard is waited for once."""
        clock = self._segment.clock
        end = clock.now + timeout
        self._heard = {kind: time for kind, time in self._heard.items() if time == clock.now}
        while not is_over() and clock.now < end:
            self._segment.advance_to(min(clock.next_deadline, end))
        over = is_over()
        self._heard.clear()
        return over


class Master(canopen.Network):
    """The master's end of a segment: what it sends, the twins have answered when this returns."""

    def __init__(self, segment: Segment[Node]) -> None:
        super().__init__()
        self._segment = segment
        self._notifies = False
        self._standstill = Standstill(MOST_SENT)
        segment.masters.append(self._hear)

    def __setitem__(self, node_id: int, node: canopen.RemoteNode | canopen.LocalNode) -> None:
        if isinstance(node, canopen.RemoteNode):
            node.nmt = NmtOfBench(node.nmt, self._segment)
        super().__setitem__(node_id, node)

    def send_message(self, can_id: int, data: Sequence[int], remote: bool = False) -> None:
        """What canopen calls to send.

        Raises:
            SimulatedTimeError: an SDO request in a callback: no real bus would answer it in time.
            OutOfTime: one of many, many frames while no time passes.
        """
        if self._notifies and not remote and _is_sdo_request(can_id):
            raise SimulatedTimeError(
                f"an SDO request in a callback, at {place_of(get_ident())}: on a real bus the"
                " thread that would receive the answer is in this callback. Note here what has"
                " come, and ask when it is over"
            )
        if not self._standstill.goes_on(self._segment.clock.ticks):
            raise OutOfTime(
                f"a loop sends and lets no time pass, at {place_of(get_ident())}: on a bench time"
                " passes in run() alone"
            )
        self._segment.send(Frame(can_id, bytes(data), remote, can_id > 0x7FF))

    def send_periodic(
        self, can_id: int, data: Sequence[int] | None, period: float, remote: bool = False
    ) -> Any:
        """What canopen calls for SYNC, cyclic PDOs and node guarding, every `period` seconds."""
        frame = Frame(can_id, bytes(data or ()), remote, can_id > 0x7FF)
        return PeriodicFrame(self._segment.clock, period, frame, self._segment.send)

    def _hear(self, frame: Frame, sender: str) -> None:
        """What the twins send, as far as canopen knows it: no remote frames."""
        if sender and not frame.remote:
            before, self._notifies = self._notifies, True
            try:
                self.notify(frame.can_id, bytearray(frame.data), self._segment.clock.now)
            finally:
                self._notifies = before


def _is_sdo_request(can_id: int) -> bool:
    known = classify(can_id)
    return known is not None and known.cob is Cob.SDO_REQUEST
