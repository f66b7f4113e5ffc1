"""Frames of a node or of the master."""

import re
from dataclasses import dataclass
from functools import cached_property
from re import Pattern

from simulators.frame import Frame, pattern
from simulators.node import Node
from simulators.replay.signs.sign import Happening, Sent, Sign
from simulators.services import State
from simulators.services.emcy import EMCY_LENGTH, emcy_id, emcy_of
from simulators.services.heartbeat import STATE_BYTE


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
