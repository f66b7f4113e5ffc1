"""What the control port says, as its OpenAPI description tells it to programs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Scalar = bool | int | float | str | None
SCALARS = ("bool", "int", "float", "str")
"""What pydantic calls them at the end of a place."""


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
class CurveNow:
    """A quantity as an instrument would show it."""

    label: str
    unit: str
    actual: float | None
    """None while there is none."""
    wanted: float | None
    """The set value beside it, if there is one."""


@dataclass(frozen=True)
class BandNow:
    """The device's own state, beside that of NMT."""

    label: str
    mood: str
    """How it is to be seen, from harmless to bad: OFF, WAITING, ACTIVE, WARNING or ERROR."""


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
    curves: Sequence[CurveNow]
    band: BandNow | None


@dataclass(frozen=True)
class Setting:
    """A setting with its value and what it takes."""

    name: str
    value: Scalar
    default: Scalar
    text: str
    type: Literal["boolean", "integer", "number", "text", "choice"]
    choices: Sequence[Scalar]
    optional: bool
    """Whether it may be null."""
    unit: str
    low: float | None
    high: float | None
    assumed: str
    """The number of the assumption behind the default; empty if a manual prints it."""
    live: bool
    """Whether it may be changed while the power is on."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a fault."""

    text: str
    type: Literal["integer", "number", "text", "number or text"]
    default: Scalar
    """None: it has to be given."""
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Fault:
    """A fault that can be injected."""

    level: str
    """device, protocol, node or line."""
    text: str
    sees: str
    """What a master should see of it, if the text does not say so."""
    lasting: bool
    """Whether it stays until it is cleared, or heals."""
    weather: str
    """From which weather on it is to be expected: mild, rough or hostile."""
    why: str
    """Why it is in that weather."""
    parameters: Mapping[str, Parameter]


@dataclass(frozen=True)
class Faults:
    """What can go wrong with a node, and what has."""

    known: Mapping[str, Fault]
    active: Sequence[ActiveFault]


@dataclass(frozen=True)
class ObjectEntry:
    """An entry of the object dictionary."""

    address: str
    """Such as 0x1018:01."""
    name: str
    type: str
    access: str
    low: float | None
    high: float | None
    section: str
    """Of the manual."""


@dataclass(frozen=True)
class Event:
    """Something that happens; what else it tells depends on its kind."""

    kind: str
    """frame, emcy, state, order, step, inject, clear, outcome, note (a warning) or lost."""
    moment: int
    node: str
    """Whom it is about, or who has sent it; empty for the bus, or somebody else."""
    words: str


@dataclass(frozen=True)
class FrameEvent(Event):
    """A frame."""

    frame: str
    """In the notation of cansend."""
    why: Sequence[str]
    """What was out of the ordinary, of a refusal only: ask `why` for others."""


@dataclass(frozen=True)
class EmcyEvent(Event):
    """An emergency, beside its frame."""

    error: Emergency


@dataclass(frozen=True)
class DetailedEvent(Event):
    """Any other, with what there is to say of it."""

    details: Mapping[str, Any]


@dataclass(frozen=True)
class ScenarioRun:
    """A scenario that has been started, and what has come of it so far."""

    running: bool
    file: str
    name: str
    verdict: str
    """PASS, SKIP, FAIL or ERROR; while it runs what is not decided counts as ERROR."""
    seed: int
    duration: float
    """Seconds of it that have been played."""
    outcomes: Sequence[Mapping[str, Any]]
