"""HEINZMANN CAN between the two units. It is not public: telegrams and times are ours (A-23, A-24).

A telegram goes from the interface of a running programme into one direction of the link, and into
the interface at its end, if the node numbers match. What is wrong is at a plug, or in a direction.
"""

from collections import deque
from dataclasses import dataclass, field
from operator import attrgetter
from typing import NamedTuple

from canopen_twins.devices.gateway.model.configuration import InitPart, Refusal
from canopen_twins.devices.gateway.model.errors import CAN_BUS_1, CAN_COMM_1, CanopenError, bit
from canopen_twins.devices.gateway.model.parameters import Store, Unit
from canopen_twins.devices.gateway.model.state import GatewayState, GovernorCommand
from canopen_twins.devices.gateway.model.timing import MILLISECOND, NEVER, Time


class GovernorAlive(NamedTuple):
    """Every fourth main cycle."""

    errors: CanopenError


class Command(NamedTuple):
    """An order to the state machine; `fresh`: the governor was reset as late as the gateway."""

    command: GovernorCommand
    session: int
    fresh: bool


class InitData(NamedTuple):
    """One piece of the configuration."""

    session: int
    part: InitPart


class InitEnd(NamedTuple):
    """How many pieces there were."""

    session: int
    pieces: int


class Binary(NamedTuple):
    """Errors and engine state of the governor, every main cycle."""

    present: int
    engine: int
    errors: CanopenError


class TpdoData(NamedTuple):
    """The values of one analogue TPDO, internal, in the order of its slots."""

    number: int
    words: tuple[int, ...]


class GatewayAlive(NamedTuple):
    """Every fourth main cycle and whenever something in it has changed."""

    state: GatewayState
    epoch: int
    """Session of the governor's last command; 0 after a reset."""
    ready: bool
    """Whether an initialisation makes sense: nothing is wrong that forbids it."""
    errors: CanopenError
    first: bool = False
    """Nothing was told since the last reset."""


class InitReady(NamedTuple):
    """The gateway waits for its configuration."""

    session: int


class InitResult(NamedTuple):
    """The verdict on the configuration; no refusal is a yes."""

    session: int
    refusal: Refusal | None


class RpdoData(NamedTuple):
    """The words of an RPDO as received."""

    number: int
    words: tuple[int, ...]


class ClearErrors(NamedTuple):
    """Errors were cleared in the other unit (9.1)."""


FromGovernor = GovernorAlive | Command | InitData | InitEnd | Binary | TpdoData | ClearErrors
FromGateway = GatewayAlive | InitReady | InitResult | RpdoData | ClearErrors
Body = FromGovernor | FromGateway


class Telegram(NamedTuple):
    """A body with the HEINZMANN CAN node numbers of sender and addressee."""

    sender: int
    addressee: int
    body: Body


@dataclass
class Direction:
    """Telegrams on their way to one unit; they never overtake each other."""

    time: Time
    delay: int = MILLISECOND
    """Microseconds a telegram takes (A-24)."""
    cut: bool = False
    drop: int = 0
    """How many of the next telegrams are lost."""
    due: int = field(default=NEVER, init=False)
    """When the next telegram arrives, us; NEVER if none is on its way."""
    _underway: deque[tuple[int, Telegram]] = field(default_factory=deque, init=False)

    @property
    def underway(self) -> bool:
        """Whether there is a telegram on its way."""
        return bool(self._underway)

    def send(self, telegram: Telegram) -> None:
        """Put a telegram on its way, or lose it."""
        if self.cut:
            return
        if self.drop:
            self.drop -= 1
            return
        due = self.time.now + self.delay
        if self._underway:
            due = max(due, self._underway[-1][0])
        else:
            self.due = due
        self._underway.append((due, telegram))

    def arrive(self) -> Telegram:
        """Take the next telegram out."""
        telegram = self._underway.popleft()[1]
        self.due = self._underway[0][0] if self._underway else NEVER
        return telegram


class Link:
    """Both directions, and whether the units that are connected understand each other."""

    def __init__(self, time: Time) -> None:
        self.time = time
        self.to = {unit: Direction(time) for unit in Unit}
        self.disturbed = False
        """Whether the units talk at different bit rates, which is a bus error in both (7.2.1)."""
        self._bit_rates: dict[Unit, int] = {}

    def connect(self, unit: Unit, bit_rate: int) -> None:
        """A unit runs, with so many kBit/s; one set by hand to its registers is left aside."""
        self._bit_rates[unit] = bit_rate
        self._compare()

    def disconnect(self, unit: Unit) -> None:
        """A unit does not run any more."""
        self._bit_rates.pop(unit, None)
        self._compare()

    def _compare(self) -> None:
        self.disturbed = len(set(self._bit_rates.values())) > 1


@dataclass
class Wiring:
    """The plug of one unit: what can be wrong there, whatever programme runs behind it."""

    link: Link
    out: Direction
    bus_fault: bool = False
    """The controller reports an error that initialising it again does not cure."""
    transmit_overflow: bool = False
    receive_overflow: bool = False
    duplicate: bool = False
    """A second participant with the same type and number is connected."""


SHOWN = (2401, 2402, 2403, 2404, 2410, 2411)
BUS_ERROR, COMMUNICATION_ERROR = bit(CAN_BUS_1), bit(CAN_COMM_1)
SILENCE = 500 * MILLISECOND  # longer than a reset takes


class HeinzmannCan:
    """The interface of one unit as the running programme has configured it: who is heard or missed.

    `partner` and `enable` are the numbers of parameters that differ between the units (7.1.1).
    """

    def __init__(self, wiring: Wiring, settings: Store, *, partner: int, enable: int) -> None:
        self.enabled = bool(settings[enable])
        self.node = settings[401]
        self.partner = settings[partner]
        self._wiring, self._link, self._out = wiring, wiring.link, wiring.out
        self._time = wiring.link.time
        self._patience = self._time.now + round(settings.effective(400) * 1_000_000)
        self._last_heard = self._time.now
        self._heard = False

    @property
    def bus_fault(self) -> bool:
        """3070: nothing gets in or out."""
        return self._wiring.bus_fault or self._link.disturbed

    @property
    def connected(self) -> bool:
        """Whether anything can get in or out."""
        return self.enabled and not self.bus_fault

    def send(self, body: Body) -> None:
        """Send to the partner, if the interface is switched on and able to."""
        if self.connected and not self._wiring.transmit_overflow:
            self._out.send(Telegram(self.node, self.partner, body))

    def accepts(self, telegram: Telegram) -> bool:
        """Whether a telegram gets through to the programme: the node numbers have to match."""
        return (
            telegram.sender == self.partner
            and telegram.addressee == self.node
            and self.connected
            and not self._wiring.receive_overflow
        )

    def hear(self, at: int | None = None) -> None:
        """Note that the partner is alive, or was `at` a moment, us."""
        self._last_heard = self._time.now if at is None else at
        self._heard = True

    @property
    def is_steady(self) -> bool:
        """Whether the partner is heard, and hears us."""
        return self.connected and not self._disturbed

    @property
    def silent(self) -> bool:
        """Whether the partner has been silent too long: 2403, after the delay 400."""
        now = self._time.now
        return now - self._last_heard > SILENCE and self.enabled and now >= self._patience

    @property
    def failed(self) -> bool:
        """Whether this interface is a reason of 3070 or 3071."""
        return self.bus_fault or self._disturbed

    @property
    def causes(self) -> int:
        """3070 and 3071, as far as this interface is the reason; bit k is error 3000+k."""
        causes = BUS_ERROR if self.bus_fault else 0
        return causes | COMMUNICATION_ERROR if self._disturbed else causes

    @property
    def _disturbed(self) -> bool:
        wiring = self._wiring
        content = wiring.transmit_overflow or wiring.receive_overflow or wiring.duplicate
        return content or self.silent

    def shows(self, number: int) -> int:
        """One of the parameters 2401 to 2404, 2410 and 2411: bit n stands for device n (7.2.1)."""
        wiring, device = self._wiring, 1 << self.partner
        active = device if self._heard and not self.silent else 0
        return {
            2401: device * wiring.transmit_overflow,
            2402: device * wiring.receive_overflow,
            2403: device * self.silent,
            2404: int(wiring.duplicate),  # one bit, as its range says
            2410: active >> 16,
            2411: active & 0xFFFF,
        }[number]


WIRING = attrgetter("bus_fault", "transmit_overflow", "receive_overflow", "duplicate")
DIRECTION = attrgetter("delay", "cut", "drop")
LINK = attrgetter("disturbed")
"""What becomes of a telegram, besides the programmes that send and receive it."""
