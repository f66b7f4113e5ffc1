"""What is waited for or expected of frames: emergencies, heartbeats and NMT commands among them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from re import Pattern

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
)
from canopen_twins.scenario.bus_events import BusEvent, Sent, Source
from canopen_twins.scenario.matchers import Matcher
from canopen_twins.slave.emcy import EMCY_LENGTH, emcy_id, emcy_of
from canopen_twins.slave.nmt import ALL_NODES, STATE_BYTE
from canopen_twins.slave.service import State

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
