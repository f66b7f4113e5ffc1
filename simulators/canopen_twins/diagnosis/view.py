"""A node with its event log, its dictionary and its manual: what every explanation looks at."""

from collections.abc import Container, Sequence
from functools import cached_property
from typing import NamedTuple

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.bus.segment import Record
from canopen_twins.bus.wire import GRAIN, NOT_BOOTED, LogEntry
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.sections import sections
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import Address
from canopen_twins.slave.service import State


class Line(NamedTuple):
    """An explanation, and the record it is about."""

    record: Record
    text: str


class Strike(NamedTuple):
    """A frame that a fault has struck, at a time of the records."""

    time: float
    about: str
    fault: str

    def between(self, begin: float, end: float) -> bool:
        """Whether it was struck from one time of the records to another."""
        return begin - GRAIN <= self.time <= end + GRAIN


class View:
    """`since` is where the time of the records begins, in seconds of the node's clock."""

    def __init__(self, node: Node, records: Sequence[Record] = (), since: float = 0.0) -> None:
        self.node = node
        self.records = records
        self.since = since
        self.sections = sections(node.device.eds)
        self._events = node.wire.events

    @property
    def node_id(self) -> int:
        """The node id in force, or the one to boot with."""
        return self.node.node_id

    def is_own(self, record: Record) -> bool:
        """Whether the node has sent a frame."""
        return record.sender == self.node.wire.name

    def named(self, address: Address) -> str:
        """An object with its section: `Run command (manual 7.3.9)`."""
        index, subindex = address
        item = self._dictionary.indices.get(index)
        if item is not None and not isinstance(item, ODVariable):
            item = item.subindices.get(subindex, item)
        name = getattr(item, "qualname", getattr(item, "name", address_text(address)))
        return name + in_brackets(self.sections.object(address))

    def service(self, name: str) -> str:
        """The section of a service, in brackets."""
        return in_brackets(self.sections.service(name))

    def may(self, time: float, active: Container[str]) -> bool:
        """Whether the node may have been in one of these states at a time of the records."""
        states = self._events.states(self.since + time)
        return not states or any(state in active for state in states)

    def unable(self, time: float, active: Container[str], what: str) -> str:
        """The NMT state in which a service has no say; empty if it had one all the moment.

        One moment may see two states: a frame that was not answered came in the wrong one.
        """
        states = self._events.states(self.since + time)
        if all(state in active for state in states):
            return ""
        if states & {NOT_BOOTED, State.INITIALISING}:
            return f"the node was not on the bus{self.service('silence')}"
        state = min(state for state in states if state not in active).lower()
        return f"the node was {state}, without {what}{self.service('states')}"

    def refusal(self, frame: object, begin: float, end: float) -> LogEntry | None:
        """What the node logged of a frame from one time of the records to another."""
        first, last = self.since + begin - GRAIN, self.since + end + GRAIN
        entries = (each for each in self._events.refusals if first <= each.time <= last)
        return next((each for each in entries if each.about == str(frame)), None)

    def strikes(self) -> list[Strike]:
        """What faults have struck lately."""
        logged = self._events.strikes
        return [Strike(each.time - self.since, each.about, each.words) for each in logged]

    @cached_property
    def _dictionary(self) -> ObjectDictionary:
        return self.node.dictionary


def in_brackets(source: str) -> str:
    """A section behind what it is about; nothing for none."""
    return f" ({source})" if source else ""
