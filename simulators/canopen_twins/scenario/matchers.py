"""What is waited for or expected of a node or of the master: frames, writes, states, values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from canopen_twins.device.node import Node
from canopen_twins.diagnosis.expected import (
    Expected,
    ExpectedState,
    ExpectedValues,
    ExpectedWrites,
)
from canopen_twins.scenario.bus_events import BusEvent, Changed, Source, Wrote
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import NoValue, Wanted, value_now, value_of
from canopen_twins.slave.object import COMMUNICATION_AREA
from canopen_twins.slave.service import State


class Matcher:
    """Something that can be seen of a node or of the master; `str` says in words what is meant."""

    polled: ClassVar[bool] = False
    """Whether it is seen by a look at the node, not in the events of the bus."""
    by_master: bool = False
    """Whether a master does it."""

    @property
    def stands(self) -> bool:
        """Whether what a look has shown holds for as long as the node has not changed."""
        return True

    @property
    def parts(self) -> tuple[Matcher, ...]:
        """What has all to be seen, in any order."""
        return (self,)

    @property
    def expected(self) -> Expected | None:
        """What it is to a diagnosis that tells why it has not come."""
        return None

    @property
    def unwanted(self) -> Expected | None:
        """The same where it has come and should not have."""
        return None

    def source(self, node: Node) -> Source | None:
        """Where the events are that it may match; None: it is polled."""
        return None

    def matches(self, event: BusEvent, node: Node) -> bool:
        """Whether this is what is meant."""
        return False

    def resembles(self, event: BusEvent, node: Node) -> bool:
        """Whether this is worth telling where what is meant has not come; that itself always is."""
        return self.matches(event, node)

    def describe(self, event: BusEvent) -> str:
        """In words what `matches` or `resembles` has said yes to."""
        raise NotImplementedError

    def poll(self, node: Node) -> tuple[bool, str]:
        """Whether it is so now, and how it is in words; nobody notices the look."""
        raise NotImplementedError


@dataclass(frozen=True)
class Condition:
    """The moment at which a matcher of a node matches for the n-th time.

    It is watched for from the moment the step above begins, and behind what set that one off.
    """

    matcher: Matcher
    node: str
    """The name of the node it is about."""
    nth: int = 1
    missing: float | None = None
    """If it is the moment when it has not matched again for so many seconds."""

    def __str__(self) -> str:
        gone = "" if self.missing is None else f" missing for {self.missing:g} s"
        return f"{self.matcher}{gone}{f' ({self.nth} times)' if self.nth > 1 else ''}"


# NMT states


@dataclass(frozen=True)
class Entered(Matcher):
    """The node enters an NMT state; one that is in it already does not."""

    state: State

    @property
    def expected(self) -> Expected:
        """The state."""
        return ExpectedState(self.state)

    def source(self, node: Node) -> Source:
        """States of the node."""
        return Changed, node

    def matches(self, event: BusEvent, node: Node) -> bool:
        """This state."""
        return self.resembles(event, node) and self.state is _state(event)

    def resembles(self, event: BusEvent, node: Node) -> bool:
        """Any state of the node."""
        return isinstance(event, Changed) and event.node is node

    def describe(self, event: BusEvent) -> str:
        """The state."""
        return _state(event).lower()

    def __str__(self) -> str:
        return f"state {self.state.lower()}"


@dataclass(frozen=True)
class IsIn(Matcher):
    """The node is in an NMT state at a look, whenever it has entered it."""

    state: State
    polled = True

    @property
    def expected(self) -> Expected:
        """The state."""
        return ExpectedState(self.state)

    def poll(self, node: Node) -> tuple[bool, str]:
        """Whether it is in the state at this moment."""
        return node.state is self.state, node.state.lower()

    def __str__(self) -> str:
        return f"in NMT state {self.state.lower()}"


def _state(event: BusEvent) -> State:
    assert isinstance(event, Changed)
    return event.state


# Values of objects


@dataclass(frozen=True)
class Written(Matcher):
    """The master writes objects, by SDO or with an RPDO: all of them, in any order."""

    wanted: tuple[tuple[Target, Wanted], ...]
    by_master = True

    @property
    def expected(self) -> Expected:
        """That they are written."""
        return ExpectedWrites([target.address for target, _ in self.wanted])

    @property
    def parts(self) -> tuple[Matcher, ...]:
        """Each object is written for itself."""
        return tuple(Written((one,)) for one in self.wanted)

    def source(self, node: Node) -> Source:
        """Whatever the master writes to the node."""
        return Wrote, node

    def matches(self, event: BusEvent, node: Node) -> bool:
        """One of the objects, with the value that is meant."""
        return isinstance(event, Wrote) and any(
            _value_written(target, event) in wanted
            for target, wanted in self.wanted
            if (event.node, event.address) == (node, target.address)
        )

    def resembles(self, event: BusEvent, node: Node) -> bool:
        """One of the objects."""
        return isinstance(event, Wrote) and any(
            (event.node, event.address) == (node, target.address) for target, _ in self.wanted
        )

    def describe(self, event: BusEvent) -> str:
        """The object, and the value it is to have."""
        assert isinstance(event, Wrote)
        return next(
            f"{target} = {wanted.tell(_value_written(target, event))}"
            for target, wanted in self.wanted
            if target.address == event.address
        )

    def __str__(self) -> str:
        return f"write {', '.join(f'{target} = {wanted}' for target, wanted in self.wanted)}"


def _value_written(target: Target, wrote: Wrote) -> object:
    return value_of(target, wrote.data, wrote.sized)


@dataclass(frozen=True)
class Holds(Matcher):
    """Objects have values; the look at them leaves no trace on the bus nor in the device."""

    wanted: tuple[tuple[Target, Wanted], ...]
    polled = True

    @property
    def expected(self) -> Expected:
        """Their values, whichever they should have or not have."""
        return ExpectedValues([target.address for target, _ in self.wanted])

    unwanted = expected

    @cached_property
    def stands(self) -> bool:
        """Unless a service may have it: of those one is a clock (0x1013)."""
        return all(target.address[0] not in COMMUNICATION_AREA for target, _ in self.wanted)

    def poll(self, node: Node) -> tuple[bool, str]:
        """Whether all of them hold at this moment."""
        values = [(target, wanted, value_now(node, target)) for target, wanted in self.wanted]
        told = (f"{target} is {_told(wanted, value)}" for target, wanted, value in values)
        return all(_is(wanted, value) for _, wanted, value in values), ", ".join(told)

    def __str__(self) -> str:
        return ", ".join(f"{target} {wanted}" for target, wanted in self.wanted)


def _is(wanted: Wanted, value: object) -> bool:
    return not isinstance(value, NoValue) and value in wanted


def _told(wanted: Wanted, value: object) -> str:
    return str(value) if isinstance(value, NoValue) else wanted.tell(value)
