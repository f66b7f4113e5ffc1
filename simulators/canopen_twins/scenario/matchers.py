"""What is waited for or expected of a node or of the master: frames, writes, states, values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from re import Pattern
from typing import ClassVar

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame, pattern
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.expected import (
    Expected,
    ExpectedCommand,
    ExpectedEmcy,
    ExpectedFrame,
    ExpectedHeartbeat,
    ExpectedSilence,
    ExpectedState,
    ExpectedValues,
    ExpectedWrites,
)
from canopen_twins.scenario.bus_events import BusEvent, Changed, Sent, Source, Wrote
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import NoValue, Wanted, value_now, value_of
from canopen_twins.slave.emcy import EMCY_LENGTH, emcy_id, emcy_of
from canopen_twins.slave.nmt import ALL_NODES, STATE_BYTE
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


# Frames

STANDARD_ID = re.compile("[0-9A-F]{3}")
STATES = {byte: state for state, byte in STATE_BYTE.items() if byte}
COMMANDS: Mapping[str, int] = {
    "start": 0x01,
    "stop": 0x02,
    "pre-operational": 0x80,
    "reset-node": 0x81,
    "reset-communication": 0x82,
}
NAMES = {command: name for name, command in COMMANDS.items()}
COMMAND_LENGTH = 2
FIRST_ERROR = 0x0100


class FrameMatcher(Matcher):
    """Picks from the frames of one node, or from those of the master."""

    def source(self, node: Node) -> Source:
        """Frames of the right sender."""
        return Sent, None if self.by_master else node

    def matches(self, event: BusEvent, node: Node) -> bool:
        """A frame of the right sender that is meant."""
        return self._is_from(event, node) and self.fits(_frame(event), node)

    def resembles(self, event: BusEvent, node: Node) -> bool:
        """A frame of the right sender that is like what is meant."""
        return self._is_from(event, node) and self.is_like(_frame(event), node)

    def describe(self, event: BusEvent) -> str:
        """The frame."""
        return self.words(_frame(event))

    def _is_from(self, event: BusEvent, node: Node) -> bool:
        sender = None if self.by_master else node
        return isinstance(event, Sent) and event.node is sender

    def fits(self, frame: Frame, node: Node) -> bool:
        """Whether a frame is meant."""
        return True

    def is_like(self, frame: Frame, node: Node) -> bool:
        """Whether a frame that may not be meant is worth telling."""
        return self.fits(frame, node)

    def words(self, frame: Frame) -> str:
        """A frame as cansend has it."""
        return str(frame)


def _frame(event: BusEvent) -> Frame:
    assert isinstance(event, Sent)
    return event.frame


@dataclass(frozen=True)
class AnyFrame(FrameMatcher):
    """Whatever is sent."""

    by_master: bool = False

    @property
    def unwanted(self) -> Expected | None:
        """A silence that a node should have kept."""
        return None if self.by_master else ExpectedSilence()

    def __str__(self) -> str:
        return f"frame{_whose(self)}"


@dataclass(frozen=True)
class FrameLike(FrameMatcher):
    """A frame in the notation of cansend, in capitals, with X for any digit and * for any rest."""

    text: str
    by_master: bool = False

    @property
    def expected(self) -> Expected | None:
        """Frames of the identifier, if it is one of 11 bits and told without an x."""
        identifier = self.text.partition("#")[0]
        told = STANDARD_ID.fullmatch(identifier) is not None
        return ExpectedFrame(int(identifier, 16)) if told else None

    def fits(self, frame: Frame, node: Node) -> bool:
        """Digit by digit."""
        return self._digits.fullmatch(str(frame)) is not None

    def is_like(self, frame: Frame, node: Node) -> bool:
        """The same identifier."""
        return self._identifier.match(str(frame)) is not None

    @cached_property
    def _identifier(self) -> Pattern[str]:
        return re.compile(self.text.split("#")[0].replace("X", "[0-9A-F]") + "#")

    @cached_property
    def _digits(self) -> Pattern[str]:
        return pattern(self.text)

    def __str__(self) -> str:
        return f"{self.text.replace('X', 'x')}{_whose(self)}"


@dataclass(frozen=True)
class EmcyLike(FrameMatcher):
    """An emergency; what is None may be anything."""

    code: int | None = None
    register: int | None = None
    detail: int | None = None
    """The manufacturer-specific error field, its first byte the lowest."""
    of_error: bool = False
    """Whether those are left out that tell of an end: 00xxh, error reset or no error (CiA 301)."""

    expected = ExpectedEmcy()

    def fits(self, frame: Frame, node: Node) -> bool:
        """Field by field."""
        if not self.is_like(frame, node):
            return False
        fields = _fields(frame)
        wanted = (self.code, self.register, self.detail)
        return not (self.of_error and fields[0] < FIRST_ERROR) and all(
            each in (None, found) for each, found in zip(wanted, fields, strict=True)
        )

    def is_like(self, frame: Frame, node: Node) -> bool:
        """Any emergency of the node."""
        return frame.can_id == _emcy_id(node) and len(frame.data) == EMCY_LENGTH

    def words(self, frame: Frame) -> str:
        """Code, register and detail."""
        return _emcy(*_fields(frame))

    def __str__(self) -> str:
        if self.of_error:
            return "EMCY of an error"
        any_emcy = self == EmcyLike()
        return "EMCY" if any_emcy else f"EMCY {_emcy(self.code, self.register, self.detail)}"


@dataclass(frozen=True)
class HeartbeatLike(FrameMatcher):
    """A heartbeat, of a state or of any; the boot-up message is none."""

    state: State | None = None

    expected = ExpectedHeartbeat()

    def fits(self, frame: Frame, node: Node) -> bool:
        """State by state."""
        return self.is_like(frame, node) and self.state in (None, STATES[frame.data[0]])

    def is_like(self, frame: Frame, node: Node) -> bool:
        """Any heartbeat of the node."""
        is_state = len(frame.data) == 1 and frame.data[0] in STATES
        return frame.can_id == identifiers.heartbeat(node.node_id) and is_state

    def words(self, frame: Frame) -> str:
        """Its state."""
        return STATES[frame.data[0]].lower()

    def __str__(self) -> str:
        return f"heartbeat {self.state.lower()}" if self.state else "heartbeat"


@dataclass(frozen=True)
class Commanded(FrameMatcher):
    """The NMT master commands the node, or all of them; None: whatever the command."""

    command: int | None = None
    by_master = True

    expected = ExpectedCommand()

    def fits(self, frame: Frame, node: Node) -> bool:
        """The command itself."""
        return self.is_like(frame, node) and self.command in (None, frame.data[0])

    def is_like(self, frame: Frame, node: Node) -> bool:
        """Any command to the node."""
        is_command = frame.can_id == identifiers.NMT and len(frame.data) == COMMAND_LENGTH
        return is_command and frame.data[1] in (ALL_NODES, node.node_id)

    def words(self, frame: Frame) -> str:
        """The command by its name."""
        return NAMES.get(frame.data[0], f"{frame.data[0]:#04x}")

    def __str__(self) -> str:
        return f"NMT {NAMES[self.command]}" if self.command is not None else "NMT command"


def _whose(matcher: FrameMatcher) -> str:
    return " of the master" if matcher.by_master else ""


def _fields(frame: Frame) -> tuple[int, int, int]:
    told = emcy_of(frame.data)
    return told.code, told.register, told.detail


def _emcy(code: int | None, register: int | None, detail: int | None) -> str:
    fields = ((code, 4), (register, 2), (detail, 2))
    return "/".join("x" * size if part is None else f"{part:0{size}X}" for part, size in fields)


def _emcy_id(node: Node) -> int | None:
    """Of a node that has just fallen silent, too: its last one may still be on its way."""
    return identifiers.emcy(node.node_id) if node.slave is None else emcy_id(node.slave)


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
