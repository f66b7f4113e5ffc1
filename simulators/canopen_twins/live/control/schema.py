"""What the control port says, as its OpenAPI description tells it to programs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Scalar = bool | int | float | str | None


@dataclass(frozen=True)
class Refusal:
    """Why something was not done, in one line."""

    detail: str


@dataclass(frozen=True)
class Done:
    """Something has been done, and what it brought about has been sent."""

    moment: int
    """Microseconds of the clock of the bus at which it took effect."""


@dataclass(frozen=True)
class NodeName:
    """A node."""

    name: str
    title: str
    """Of its device: maker, name, manual."""
    node_id: int
    state: str
    """NMT state as canopen names it; INITIALISING while it is silent."""
    powered: bool


@dataclass(frozen=True)
class ActiveFault:
    """A fault that is there."""

    name: str
    parameters: Mapping[str, Any]
    words: str


@dataclass(frozen=True)
class Emergency:
    """An error as it is told by an EMCY."""

    code: int
    register: int
    detail: int
    """The manufacturer-specific error field as one number, its first byte the lowest."""
    label: str


@dataclass(frozen=True)
class NodeState(NodeName):
    """A node as it is at a moment."""

    moment: int
    """Microseconds of the clock of the bus."""
    booting: bool
    silence: str
    """Why it is not on the bus, in words; empty if it is."""
    report: Mapping[str, Any]
    """How its model is, in engineering units."""
    faults: Sequence[ActiveFault]
    errors: Sequence[Emergency]
    """What is wrong at this moment."""
    history: Sequence[Emergency]
    """What 0x1003 keeps, the latest first."""
