"""Which frames of a node are meant."""

from dataclasses import dataclass
from functools import cached_property
from re import Pattern as Expression
from typing import Protocol

from simulators.node import Node
from simulators.services import State
from simulators.services.heartbeat import STATE_BYTE
from simulators.wire import Frame, pattern

EMCY_LENGTH = 8


class Pattern(Protocol):
    """`str` says in words what is meant."""

    def fits(self, frame: Frame, node: Node) -> bool:
        """Whether a frame of the node is meant."""

    def is_kin(self, frame: Frame, node: Node) -> bool:
        """Whether a frame that may not fit is worth telling."""

    def tell(self, frame: Frame) -> str:
        """A frame in words."""


@dataclass(frozen=True)
class AnyFrame:
    """Whatever the node sends."""

    def fits(self, frame: Frame, node: Node) -> bool:
        """Every frame."""
        return True

    is_kin = fits

    def tell(self, frame: Frame) -> str:
        """As cansend has it."""
        return str(frame)

    def __str__(self) -> str:
        return "frame"


@dataclass(frozen=True)
class FrameLike:
    """A frame in the notation of cansend, in capitals, with X for any digit and * for any rest."""

    text: str

    def fits(self, frame: Frame, node: Node) -> bool:
        """Digit by digit."""
        return self._digits.fullmatch(str(frame)) is not None

    def is_kin(self, frame: Frame, node: Node) -> bool:
        """The same identifier."""
        return str(frame).split("#")[0] == self.text.split("#")[0]

    def tell(self, frame: Frame) -> str:
        """As cansend has it."""
        return str(frame)

    @cached_property
    def _digits(self) -> Expression[str]:
        return pattern(self.text)

    def __str__(self) -> str:
        return self.text.replace("X", "x")


@dataclass(frozen=True)
class EmcyLike:
    """An emergency; what is None may be anything."""

    code: int | None = None
    register: int | None = None
    detail: int | None = None
    """The manufacturer-specific error field, its first byte the lowest."""

    def fits(self, frame: Frame, node: Node) -> bool:
        """Field by field."""
        return self.is_kin(frame, node) and all(
            wanted in (None, found)
            for wanted, found in zip(
                (self.code, self.register, self.detail), _fields(frame.data), strict=True
            )
        )

    def is_kin(self, frame: Frame, node: Node) -> bool:
        """Any emergency of the node."""
        return frame.can_id == _emcy_id(node) and len(frame.data) == EMCY_LENGTH

    def tell(self, frame: Frame) -> str:
        """Code, register and detail."""
        return _emcy(*_fields(frame.data))

    def __str__(self) -> str:
        any_emcy = self == EmcyLike()
        return "EMCY" if any_emcy else f"EMCY {_emcy(self.code, self.register, self.detail)}"


@dataclass(frozen=True)
class HeartbeatLike:
    """A heartbeat, of a state or of any; the boot-up message is none."""

    state: State | None = None

    def fits(self, frame: Frame, node: Node) -> bool:
        """State by state."""
        return self.is_kin(frame, node) and self.state in (None, STATES[frame.data[0]])

    def is_kin(self, frame: Frame, node: Node) -> bool:
        """Any heartbeat of the node."""
        is_state = len(frame.data) == 1 and frame.data[0] in STATES
        return frame.can_id == 0x700 + node.node_id and is_state

    def tell(self, frame: Frame) -> str:
        """Its state."""
        return STATES[frame.data[0]].lower()

    def __str__(self) -> str:
        return f"heartbeat {self.state.lower()}" if self.state else "heartbeat"


STATES = {byte: state for state, byte in STATE_BYTE.items() if byte}


def _fields(data: bytes) -> tuple[int, int, int]:
    return int.from_bytes(data[:2], "little"), data[2], int.from_bytes(data[3:], "little")


def _emcy(code: int | None, register: int | None, detail: int | None) -> str:
    fields = ((code, 4), (register, 2), (detail, 2))
    return "/".join("x" * size if part is None else f"{part:0{size}X}" for part, size in fields)


def _emcy_id(node: Node) -> int:
    slave = node.slave
    if slave is None or not slave.has(0x1014):
        return 0x80 + node.node_id
    return slave.number(0x1014) & 0x7FF
