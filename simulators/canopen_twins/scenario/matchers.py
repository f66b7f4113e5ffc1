"""What happens on a bus and at a node, and what it has to be to be a sign of something."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from re import Pattern
from typing import ClassVar, NamedTuple

from canopen_twins.bus.frame import Frame, pattern
from canopen_twins.device.node import Node
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import value_of
from canopen_twins.slave.emcy import EMCY_LENGTH, emcy_id, emcy_of
from canopen_twins.slave.nmt import STATE_BYTE
from canopen_twins.slave.object import Address, Rejected
from canopen_twins.slave.service import State


class Sent(NamedTuple):
    """A frame on the bus."""

    frame: Frame
    node: Node | None
    """Who has sent it; None for the master, which is whoever is no node of the scenario."""


class Wrote(NamedTuple):
    """The master writes an object, by SDO or with an RPDO; whether it is refused does not matter.

    An RPDO writes several at once: one after the other.
    """

    node: Node
    address: Address
    data: bytes
    sized: bool = True
    """Whether all of the bytes count; with an SDO the master may leave that to the object."""


class Changed(NamedTuple):
    """A node enters an NMT state."""

    node: Node
    state: State


Happening = Sent | Wrote | Changed


class Sign:
    """Something that can be seen of a node or of the master; `str` says in words what is meant."""

    looks: ClassVar[bool] = False
    """Whether it is seen by a look at the node, not in what happens."""

    @property
    def parts(self) -> tuple[Sign, ...]:
        """The signs that have all to be seen, in any order."""
        return (self,)

    @property
    def addresses(self) -> Sequence[Address]:
        """The objects it is about."""
        return ()

    def sees(self, happening: Happening, node: Node) -> bool:
        """Whether this is what is meant."""
        return False

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """Whether this is worth telling where what is meant has not come; that itself always is."""
        return self.sees(happening, node)

    def tell(self, happening: Happening) -> str:
        """In words what `sees` or `is_kin` has said yes to."""
        raise NotImplementedError

    def look(self, node: Node) -> tuple[bool, str]:
        """Whether it is so now, and how it is in words."""
        raise NotImplementedError


@dataclass(frozen=True)
class Range:
    """Numbers, both ends included."""

    low: float = -inf
    high: float = inf
    hexadecimal: bool = False
    """Whether values are told in hexadecimal."""

    def tell(self, value: object) -> str:
        """A value, as the file would have it."""
        return f"{value:#06x}" if self.hexadecimal and isinstance(value, int) else f"{value}"

    def __contains__(self, value: object) -> bool:
        return isinstance(value, (int, float)) and self.low <= value <= self.high

    def __str__(self) -> str:
        if self.low == self.high:
            return self.tell(self.low)
        told = f"{self.tell(self.low)}..{self.tell(self.high)}"
        return told.replace("-inf..", "at most ").replace("..inf", " or more")


@dataclass(frozen=True)
class Text:
    """The one text that is meant."""

    text: str

    def tell(self, value: object) -> str:
        """A value in quotes."""
        return repr(value)

    def __contains__(self, value: object) -> bool:
        return value == self.text

    def __str__(self) -> str:
        return repr(self.text)


@dataclass(frozen=True)
class Anything:
    """Whatever it is."""

    def tell(self, value: object) -> str:
        """A value as it is."""
        return f"{value}"

    def __contains__(self, value: object) -> bool:
        return True

    def __str__(self) -> str:
        return "any"


Wanted = Range | Text | Anything


class FrameSign(Sign):
    """Picks from the frames of one node, or from those of the master."""

    by_master: bool = False

    def sees(self, happening: Happening, node: Node) -> bool:
        """A frame of the right sender that is meant."""
        return self._is_from(happening, node) and self.fits(_frame(happening), node)

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """A frame of the right sender that is like what is meant."""
        return self._is_from(happening, node) and self.resembles(_frame(happening), node)

    def tell(self, happening: Happening) -> str:
        """The frame."""
        return self.words(_frame(happening))

    def _is_from(self, happening: Happening, node: Node) -> bool:
        sender = None if self.by_master else node
        return isinstance(happening, Sent) and happening.node is sender

    def fits(self, frame: Frame, node: Node) -> bool:
        """Whether a frame is meant."""
        return True

    def resembles(self, frame: Frame, node: Node) -> bool:
        """Whether a frame that may not fit is worth telling."""
        return self.fits(frame, node)

    def words(self, frame: Frame) -> str:
        """A frame as cansend has it."""
        return str(frame)


def _frame(happening: Happening) -> Frame:
    assert isinstance(happening, Sent)
    return happening.frame


@dataclass(frozen=True)
class AnyFrame(FrameSign):
    """Whatever is sent."""

    by_master: bool = False

    def __str__(self) -> str:
        return f"frame{_whose(self)}"


@dataclass(frozen=True)
class FrameLike(FrameSign):
    """A frame in the notation of cansend, in capitals, with X for any digit and * for any rest."""

    text: str
    by_master: bool = False

    def fits(self, frame: Frame, node: Node) -> bool:
        """Digit by digit."""
        return self._digits.fullmatch(str(frame)) is not None

    def resembles(self, frame: Frame, node: Node) -> bool:
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
class EmcyLike(FrameSign):
    """An emergency; what is None may be anything."""

    code: int | None = None
    register: int | None = None
    detail: int | None = None
    """The manufacturer-specific error field, its first byte the lowest."""

    def fits(self, frame: Frame, node: Node) -> bool:
        """Field by field."""
        return self.resembles(frame, node) and all(
            wanted in (None, found)
            for wanted, found in zip(
                (self.code, self.register, self.detail), _fields(frame), strict=True
            )
        )

    def resembles(self, frame: Frame, node: Node) -> bool:
        """Any emergency of the node."""
        return frame.can_id == _emcy_id(node) and len(frame.data) == EMCY_LENGTH

    def words(self, frame: Frame) -> str:
        """Code, register and detail."""
        return _emcy(*_fields(frame))

    def __str__(self) -> str:
        any_emcy = self == EmcyLike()
        return "EMCY" if any_emcy else f"EMCY {_emcy(self.code, self.register, self.detail)}"


@dataclass(frozen=True)
class HeartbeatLike(FrameSign):
    """A heartbeat, of a state or of any; the boot-up message is none."""

    state: State | None = None

    def fits(self, frame: Frame, node: Node) -> bool:
        """State by state."""
        return self.resembles(frame, node) and self.state in (None, STATES[frame.data[0]])

    def resembles(self, frame: Frame, node: Node) -> bool:
        """Any heartbeat of the node."""
        is_state = len(frame.data) == 1 and frame.data[0] in STATES
        return frame.can_id == 0x700 + node.node_id and is_state

    def words(self, frame: Frame) -> str:
        """Its state."""
        return STATES[frame.data[0]].lower()

    def __str__(self) -> str:
        return f"heartbeat {self.state.lower()}" if self.state else "heartbeat"


STATES = {byte: state for state, byte in STATE_BYTE.items() if byte}


def _whose(sign: FrameSign) -> str:
    return " of the master" if sign.by_master else ""


def _fields(frame: Frame) -> tuple[int, int, int]:
    told = emcy_of(frame.data)
    return told.code, told.register, told.detail


def _emcy(code: int | None, register: int | None, detail: int | None) -> str:
    fields = ((code, 4), (register, 2), (detail, 2))
    return "/".join("x" * size if part is None else f"{part:0{size}X}" for part, size in fields)


def _emcy_id(node: Node) -> int | None:
    """Of a node that has just fallen silent, too: its last one may still be on its way."""
    return 0x80 + node.node_id if node.slave is None else emcy_id(node.slave)


@dataclass(frozen=True)
class Holds(Sign):
    """Objects have values; the look at them leaves no trace on the bus nor in the device."""

    wanted: tuple[tuple[Target, Wanted], ...]
    looks = True

    @property
    def addresses(self) -> Sequence[Address]:
        """All of them."""
        return [target.address for target, _ in self.wanted]

    def look(self, node: Node) -> tuple[bool, str]:
        """Whether all of them hold at this moment."""
        values = [(target, wanted, _value_now(node, target)) for target, wanted in self.wanted]
        told = (f"{target} is {_told(wanted, value)}" for target, wanted, value in values)
        return all(_is(wanted, value) for _, wanted, value in values), ", ".join(told)

    def __str__(self) -> str:
        return ", ".join(f"{target} {wanted}" for target, wanted in self.wanted)


@dataclass(frozen=True)
class Entered(Sign):
    """The node enters an NMT state; one that is in it already does not."""

    state: State

    def sees(self, happening: Happening, node: Node) -> bool:
        """This state."""
        return self.is_kin(happening, node) and self.state is _state(happening)

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """Any state of the node."""
        return isinstance(happening, Changed) and happening.node is node

    def tell(self, happening: Happening) -> str:
        """The state."""
        return _state(happening).lower()

    def __str__(self) -> str:
        return f"state {self.state.lower()}"


def _state(happening: Happening) -> State:
    assert isinstance(happening, Changed)
    return happening.state


class NoValue(str):
    """Why there is none; whatever is wanted, this is not it."""

    __slots__ = ()


def _is(wanted: Wanted, value: object) -> bool:
    return not isinstance(value, NoValue) and value in wanted


def _told(wanted: Wanted, value: object) -> str:
    return str(value) if isinstance(value, NoValue) else wanted.tell(value)


def _value_now(node: Node, target: Target) -> object:
    if node.slave is None:
        return NoValue("(silent)")
    try:
        entry = node.slave.entry(*target.address)
        return entry.unpack(entry.read())
    except Rejected as refusal:
        return NoValue(f"(refused: {refusal})")


COMMANDS: Mapping[str, int] = {
    "start": 0x01,
    "stop": 0x02,
    "pre-operational": 0x80,
    "reset-node": 0x81,
    "reset-communication": 0x82,
}
NAMES = {command: name for name, command in COMMANDS.items()}
ALL_NODES = 0
LENGTH = 2


@dataclass(frozen=True)
class Commanded(FrameSign):
    """The NMT master commands the node, or all of them; None: whatever the command."""

    command: int | None = None
    by_master = True

    def fits(self, frame: Frame, node: Node) -> bool:
        """The command itself."""
        return self.resembles(frame, node) and self.command in (None, frame.data[0])

    def resembles(self, frame: Frame, node: Node) -> bool:
        """Any command to the node."""
        is_command = frame.can_id == 0 and len(frame.data) == LENGTH
        return is_command and frame.data[1] in (ALL_NODES, node.node_id)

    def words(self, frame: Frame) -> str:
        """The command by its name."""
        return NAMES.get(frame.data[0], f"{frame.data[0]:#04x}")

    def __str__(self) -> str:
        return f"NMT {NAMES[self.command]}" if self.command is not None else "NMT command"


@dataclass(frozen=True)
class Written(Sign):
    """The master writes objects, by SDO or with an RPDO: all of them, in any order."""

    wanted: tuple[tuple[Target, Wanted], ...]

    @property
    def addresses(self) -> Sequence[Address]:
        """All of them."""
        return [target.address for target, _ in self.wanted]

    @property
    def parts(self) -> tuple[Sign, ...]:
        """Each object is written for itself."""
        return tuple(Written((one,)) for one in self.wanted)

    def sees(self, happening: Happening, node: Node) -> bool:
        """One of the objects, with the value that is meant."""
        return isinstance(happening, Wrote) and any(
            _value_written(target, happening) in wanted
            for target, wanted in self.wanted
            if (happening.node, happening.address) == (node, target.address)
        )

    def is_kin(self, happening: Happening, node: Node) -> bool:
        """One of the objects."""
        return isinstance(happening, Wrote) and any(
            (happening.node, happening.address) == (node, target.address)
            for target, _ in self.wanted
        )

    def tell(self, happening: Happening) -> str:
        """The object, and the value it is to have."""
        assert isinstance(happening, Wrote)
        return next(
            f"{target} = {wanted.tell(_value_written(target, happening))}"
            for target, wanted in self.wanted
            if target.address == happening.address
        )

    def __str__(self) -> str:
        return f"write {', '.join(f'{target} = {wanted}' for target, wanted in self.wanted)}"


def _value_written(target: Target, wrote: Wrote) -> object:
    return value_of(target, wrote.data, wrote.sized)


__all__ = [
    "COMMANDS",
    "AnyFrame",
    "Anything",
    "Changed",
    "Commanded",
    "EmcyLike",
    "Entered",
    "FrameLike",
    "Happening",
    "HeartbeatLike",
    "Holds",
    "Range",
    "Sent",
    "Sign",
    "Text",
    "Wanted",
    "Written",
    "Wrote",
]
