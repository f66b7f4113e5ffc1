"""What happens in a run without any fault: the moments at which a hunt lets something go wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.files.writer import Verbatim
from canopen_twins.hunt.contract import Contract
from canopen_twins.hunt.run import judged
from canopen_twins.hunt.waits import Wait
from canopen_twins.scenario import Player, Scenario, Verdict
from canopen_twins.scenario.bus_events import BusEvent, BusEvents, Changed, Sent, Wrote
from canopen_twins.scenario.frame_matchers import COMMAND_LENGTH, NAMES
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import value_of
from canopen_twins.slave.dictionary import Objects, address_text
from canopen_twins.slave.emcy import EMCY_LENGTH, emcy_id, emcy_of
from canopen_twins.slave.nmt import ALL_NODES
from canopen_twins.slave.object import Address


class Access(NamedTuple):
    """The master asks the SDO server of a node for an object."""

    node: str
    object: str
    """As a file names it."""
    access: str
    """Read or write."""
    address: Address


@dataclass
class Events:
    """Times in seconds, in their order, by what has happened then."""

    seconds: float = 0.0
    """How long the run was."""
    moments: dict[str, dict[str, list[float]]] = field(default_factory=dict)
    """By nodes, and by conditions as a file has them (their `repr`)."""
    conditions: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    """The same by their `repr`."""
    accesses: dict[Access, list[float]] = field(default_factory=dict)
    frames: dict[str, dict[str, list[float]]] = field(default_factory=dict)
    """By nodes that send or hear them, and by patterns such as 585#*."""
    waits: list[Wait] = field(default_factory=list)
    """What the master does for want of an answer, learnt from other runs."""


class EventRecorder:
    """Takes down what happens on a bus."""

    def __init__(self) -> None:
        self.events = Events()
        self._names: dict[str, Objects] = {}
        self._segment: Segment[Node]
        self._bus: BusEvents
        self._node_names: dict[Node, str] = {}

    def attach(self, segment: Segment[Node], player: Player) -> None:
        """Hear everything from now on; an observer of `play`."""
        self._segment = segment
        nodes = {node.wire.name: node for node in segment.nodes}
        self._node_names = {node: name for name, node in nodes.items()}
        self._names = {name: Objects(node.device.dictionary()) for name, node in nodes.items()}
        self._bus = BusEvents(nodes, segment.clock)
        for name in nodes:
            self._bus.follow_states(name)
            self._bus.follow_writes(name)
        self._bus.listen(self._hear, self._bus.sources)
        segment.listeners.append(self._bus.hear)

    def _hear(self, event: BusEvent) -> None:
        match event:
            case Wrote(node, address, data, sized):
                self._wrote(node, address, data, sized)
            case Changed(node, state):
                self._moment(node, {"state": str(state).lower()})
            case Sent(frame, None):
                self._asked(event)
            case Sent(frame, node) if node is not None:
                self._pattern(node, f"{frame.can_id:03X}#*")
                is_known = node.slave is not None and frame.can_id == emcy_id(node.slave)
                if is_known and len(frame.data) == EMCY_LENGTH:
                    code = Verbatim(f"{emcy_of(frame.data).code:#06x}")
                    self._moment(node, {"emcy": {"code": code}})

    def _wrote(self, node: Node, address: Address, data: bytes, sized: bool) -> None:
        name = self._name(node, address)
        target = Target(name, address, self._names[self._node_names[node]].get(name))
        value = value_of(target, data, sized)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            self._moment(node, {"write": {name: value}})
        else:
            self._moment(node, {"write": {name: "any"}})

    def _asked(self, sent: Sent) -> None:
        frame = sent.frame
        for node, name in self._node_names.items():
            self._pattern(node, f"{frame.can_id:03X}#*")
            if sdo.is_request(frame, node.node_id):
                specifier = sdo.specifier(frame.data)
                if specifier in (sdo.Ccs.UPLOAD, sdo.Ccs.DOWNLOAD):
                    access = sdo.READ if specifier == sdo.Ccs.UPLOAD else sdo.WRITE
                    address = sdo.address(frame.data)
                    key = Access(name, self._name(node, address), access, address)
                    self.events.accesses.setdefault(key, []).append(self._now)
            elif (command := _command(frame, node)) is not None:
                self._moment(node, {"nmt": command})

    def _name(self, node: Node, address: Address) -> str:
        """Its name, where that is of one object alone."""
        names = self._names[self._node_names[node]]
        text = address_text(address)
        if text not in names:
            return text
        name = str(names[text].qualname)
        return text if names.is_of_several(name) else name

    def _moment(self, node: Node, condition: Mapping[str, Any]) -> None:
        key = repr(condition)
        self.events.conditions[key] = condition
        times = self.events.moments.setdefault(self._node_names[node], {})
        times.setdefault(key, []).append(self._now)

    def _pattern(self, node: Node, pattern: str) -> None:
        patterns = self.events.frames.setdefault(self._node_names[node], {})
        patterns.setdefault(pattern, []).append(self._now)

    @property
    def _now(self) -> float:
        return self._segment.clock.ticks / MICROSECONDS


def _command(frame: Frame, node: Node) -> str | None:
    """The NMT command to a node that a frame is."""
    if frame.can_id != identifiers.NMT or len(frame.data) != COMMAND_LENGTH:
        return None
    return NAMES.get(frame.data[0]) if frame.data[1] in (ALL_NODES, node.node_id) else None


def events_of(contract: Contract, scenario: Scenario) -> tuple[Events, Verdict]:
    """What happens in a run of it, and its verdict."""
    recorder = EventRecorder()
    verdict = judged(contract, scenario, recorder.attach)
    recorder.events.seconds = verdict.seconds
    return recorder.events, verdict
