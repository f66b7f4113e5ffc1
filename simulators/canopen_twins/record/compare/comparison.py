"""A trace of real devices with their master, played to fresh twins in simulated time."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import Cob, classify
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.bus.wire import Heard
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.record.compare.agreement import Agreement
from canopen_twins.record.compare.beside import Beside
from canopen_twins.record.compare.timeline import Timeline
from canopen_twins.record.compare.tolerances import Tolerances
from canopen_twins.record.compare.unexercised import unexercised

OF_SLAVES = (Cob.EMCY, Cob.SDO_ANSWER, Cob.HEARTBEAT)
RECENT = 40  # frames that are kept
SETTLED = 100_000  # microseconds after which it is looked again for what is over


class Comparison:
    """What the devices send is held against what their twins send; all else goes to the twins.

    A twin has power from the first frame of its device on. If that is no boot-up, the trace begins
    in the middle: the twin takes over what the trace shows.
    """

    def __init__(self, devices: Mapping[str, Device], tolerances: Tolerances | None = None) -> None:
        """The devices by names, with their power off.

        Raises:
            UserError: two have one node id.
        """
        self.segment: Segment[Node] = Segment()
        self.agreement = Agreement()
        self.timeline = Timeline(self.segment)
        self._tolerances = tolerances or Tolerances()
        self._records: deque[Record] = deque(maxlen=RECENT)
        self._besides = {
            name: Beside(
                connect(self.segment, device, name),
                self.timeline,
                self.agreement,
                self._tolerances,
                self._records,
            )
            for name, device in devices.items()
        }
        self._own: dict[str, Mapping[int, object]] = {}  # as it was when the next was made of it
        self._of_devices: dict[int, Beside] = {}
        self._others: set[Heard] = set()  # identifiers of none of them
        self._settled = 0
        self.segment.masters.append(self._hear)

    @property
    def nodes(self) -> Mapping[str, Beside]:
        """By their names."""
        return self._besides

    def hear(self, tick: int, frame: Frame) -> None:
        """A frame of the trace, at its microsecond."""
        for beside in self._besides.values():
            if beside.due < self.timeline.relative(tick):
                self._hurry(tick, beside)
        leaps = len(self.timeline.left_out)
        now = self.timeline.advance(tick)
        if len(self.timeline.left_out) != leaps:
            for beside in self._besides.values():
                beside.leap()
        if now - self._settled >= SETTLED:
            self.settle(now)
        for name, beside in self._besides.items():
            beside.follow(now)
            if beside.node.wire.heard is not beside.heard:
                beside.derive()
            if beside.own is not self._own.get(name):
                self._derive()
        if not (frame.remote or frame.extended):
            its = self._of_devices.get(frame.can_id)
            if its is not None:
                its.on_device(now, frame)
                return
        self._others.add((frame.can_id, frame.remote))
        taken = [beside.on_master(now, frame) for beside in self._besides.values()]
        if not any(taken):
            self.segment.send(frame)

    def pass_time(self, tick: int) -> None:
        """Nothing has come up to a microsecond."""
        now = self.timeline.advance(tick)
        for beside in self._besides.values():
            beside.follow(now)
        if now - self._settled >= SETTLED:
            self.settle(now)

    def _hurry(self, tick: int, beside: Beside) -> None:
        """The device is silent: at the end of its time the twin is asked all the same."""
        early = self.timeline.relative(tick) - int(beside.due)
        beside.follow(self.timeline.advance(tick - early))

    def settle(self, now: int) -> None:
        """Judge what is over."""
        self._settled = now
        for beside in self._besides.values():
            beside.settle(now)

    def end(self) -> Agreement:
        """The trace is over: what there is to say about it.

        Raises:
            UserError: it has nothing of one of the nodes, or too little to compare anything.
        """
        for name, beside in self._besides.items():
            if not beside.begun:
                self._refuse(name, beside.node.node_id)
        for name, beside in self._besides.items():
            beside.end(self.timeline.now)
            beside.exercised.heard = self._others
            services = self.agreement.services(name)
            lines = unexercised(beside.node, beside.exercised, services)
            self.agreement.unexercised[name] = list(lines)
        if not self.agreement.total:
            raise UserError(f"the trace has too little of {', '.join(self._besides)} to compare")
        self.agreement.forgive(self._tolerances.lost)
        self.agreement.remarks += self.timeline.left_out
        return self.agreement

    def _refuse(self, name: str, node_id: int) -> None:
        known = [classify(can_id) for can_id, remote in self._others if not remote]
        others = sorted({each.node_id for each in known if each and each.cob in OF_SLAVES})
        told = f", but of node {', '.join(map(str, others))}" if others else ""
        raise UserError(f"the trace has nothing of node {node_id} ({name}){told}")

    def _derive(self) -> None:
        self._own = {name: beside.own for name, beside in self._besides.items()}
        self._of_devices = {
            can_id: self._besides[name] for name, own in self._own.items() for can_id in own
        }

    def _hear(self, frame: Frame, sender: str) -> None:
        self._records.append(Record(self.segment.clock.now, frame, sender))
        if (beside := self._besides.get(sender)) is not None:
            beside.on_twin(self.timeline.of_twins, frame)
