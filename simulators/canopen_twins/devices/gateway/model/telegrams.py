"""Telegrams between governor and gateway. HEINZMANN CAN is not public: these are ours (A-23)."""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from canopen_twins.devices.gateway.model.canopen_errors import CanopenError
from canopen_twins.devices.gateway.model.state import GovernorCommand, State


class Refusal(Enum):
    """Why the gateway does not accept its configuration (7.3)."""

    STRUCTURE = "init telegrams are missing"
    DUPLICATE_IDENTIFIER = "two active PDOs have the same identifier"
    RESERVED_IDENTIFIER = "an active PDO has a reserved identifier"
    OWN_IS_PARTNER = "427 and 428 are the same node"


@dataclass(frozen=True)
class Slot:
    """One word of an analogue TPDO: its place among the four assignments, and its sign."""

    word: int  # 1..4
    signed: bool


@dataclass(frozen=True)
class BinaryPart:
    """Which binary TPDOs are wanted (14401, 14402)."""

    errors: bool
    status: bool


@dataclass(frozen=True)
class TpdoPart:
    """One active analogue TPDO, 4..16."""

    number: int
    slots: tuple[Slot, ...]


@dataclass(frozen=True)
class RpdoPart:
    """One active RPDO, 1..4, and which of its words 1..4 are used."""

    number: int
    words: tuple[int, ...]


InitPart = BinaryPart | TpdoPart | RpdoPart


@dataclass(frozen=True)
class GovernorAlive:
    """Every fourth main cycle."""

    errors: CanopenError


@dataclass(frozen=True)
class Command:
    """An order to the state machine; `fresh` until the governor has initialised once."""

    command: GovernorCommand
    session: int
    fresh: bool


@dataclass(frozen=True)
class InitData:
    """One piece of the configuration."""

    session: int
    part: InitPart


@dataclass(frozen=True)
class InitEnd:
    """How many pieces there were."""

    session: int
    count: int


class Binary(NamedTuple):
    """Errors and engine state of the governor, every main cycle."""

    present: int
    engine: int
    errors: CanopenError


class TpdoData(NamedTuple):
    """The values of one analogue TPDO, internal, in the order of its slots."""

    number: int
    words: tuple[int, ...]


@dataclass(frozen=True)
class GatewayAlive:
    """Every fourth main cycle and whenever something in it has changed."""

    state: State
    epoch: int
    """Session of the governor's last command; 0 after a reset."""
    fresh: bool
    """Not initialised since the last reset."""
    ready: bool
    """Whether an initialisation makes sense: nothing is wrong that forbids it."""
    errors: CanopenError
    first: bool = False
    """Nothing was told since the last reset."""


@dataclass(frozen=True)
class InitReady:
    """The gateway waits for its configuration."""

    session: int


@dataclass(frozen=True)
class InitResult:
    """The verdict on the configuration; no refusal is a yes."""

    session: int
    refusal: Refusal | None


@dataclass(frozen=True)
class RpdoData:
    """The words of an RPDO as received."""

    number: int
    words: tuple[int, ...]


@dataclass(frozen=True)
class ClearErrors:
    """Errors were cleared in the other unit (9.1)."""


Body = (
    GovernorAlive
    | Command
    | InitData
    | InitEnd
    | Binary
    | TpdoData
    | GatewayAlive
    | InitReady
    | InitResult
    | RpdoData
    | ClearErrors
)


class Telegram(NamedTuple):
    """A body with the HEINZMANN CAN node numbers of sender and addressee."""

    sender: int
    addressee: int
    body: Body
