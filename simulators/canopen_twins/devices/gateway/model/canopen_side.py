"""CANopen side of the gateway: its state, what leaves, and how it gets over a bus fault (12423)."""

from dataclasses import dataclass, field
from enum import Enum
from operator import attrgetter
from typing import NamedTuple

from canopen_twins.devices.gateway.model.configuration import (
    DIGITAL_OUTPUT,
    HEARTBEAT_LIMIT,
    HEARTBEAT_PERIOD,
    PARTNER_NODE,
    Dictionary,
    Entry,
)
from canopen_twins.devices.gateway.model.errors import Assignment
from canopen_twins.devices.gateway.model.parameters import Store
from canopen_twins.devices.gateway.model.state import COMMUNICATING, NEXT, GatewayState, Trigger
from canopen_twins.devices.gateway.model.timing import NEVER, Watch, heartbeat_cycles

BINARY_TPDOS = (1, 2, 3)
RETRY_CYCLES = 31  # main cycles: half a second


@dataclass(frozen=True)
class BootUp:
    """The boot-up message: initialised, or over a bus fault without heartbeats (A-10)."""


@dataclass(frozen=True)
class Heartbeat:
    """The heartbeat that tells of the end of a bus fault; those in between are a matter of time."""

    state: GatewayState


class TpdoFrame(NamedTuple):
    """A TPDO 1..16 with the words it carries."""

    number: int
    words: tuple[int, ...]


Sent = BootUp | Heartbeat | TpdoFrame


class FirstTpdo(Enum):
    """What a binary TPDO is compared with on entering Operational (A-15).

    Always sent; else what was last sent, at first 0, or how it was when the dictionary was created.
    """

    ALWAYS = "always"
    NONZERO = "nonzero"
    NEVER = "never"


class Outputs:
    """What the object dictionary holds, from its creation by the init telegrams on."""

    def __init__(
        self,
        dictionary: Dictionary,
        assignment: Assignment,
        first: FirstTpdo,
        sent: dict[int, tuple[int, ...]],
        digital: tuple[int, int],
    ) -> None:
        """`sent`: the words of every binary TPDO as last sent; `digital`: errors, engine state."""
        self.dictionary = dictionary
        self._assignment, self._first = assignment, first
        self._values: dict[Entry, int] = {}
        self._sent = sent
        self._digital: tuple[int, ...] = (0,) * 7
        self._shown: tuple[int, int] | None = None
        self._told = True  # there is no change that was not sent
        self.show(*digital)
        for number in self._binary:
            nothing = tuple(0 for _ in dictionary.tpdos[number].entries)
            before = self._words(number) if first is FirstTpdo.NEVER else nothing
            if len(sent.setdefault(number, before)) != len(before):
                sent[number] = before

    @property
    def _binary(self) -> list[int]:
        return [number for number in BINARY_TPDOS if number in self.dictionary.tpdos]

    def begin(self) -> None:
        """Operational was entered: the binary TPDOs begin anew."""
        self._told = False
        if self._first is FirstTpdo.ALWAYS:
            self._sent.clear()

    def value(self, index: int, sub: int) -> int:
        """The value of a word of 2000h to 2004h; 0 before anything has come for it."""
        if index == DIGITAL_OUTPUT:
            return self._digital[sub - 1]
        return self._values.get(Entry(index, sub), 0)

    def show(self, present: int, engine: int) -> None:
        """Take over errors, bit k for 3000+k, and engine state; once per cycle of the governor."""
        if (present, engine) == self._shown:
            return
        self._shown, self._told = (present, engine), False
        self._digital = (*self._assignment.error_words(present), engine)

    def news(self) -> list[TpdoFrame]:
        """The binary TPDOs that have changed since they were last sent; they are sent now."""
        if self._told:
            return []
        self._told = True
        words = {number: self._words(number) for number in self._binary}
        changed = [TpdoFrame(n, each) for n, each in words.items() if each != self._sent.get(n)]
        self._sent.update(words)
        return changed

    def take(self, entries: tuple[Entry, ...], words: tuple[int, ...]) -> None:
        """Keep the words of a PDO in their objects."""
        self._values |= dict(zip(entries, words, strict=True))

    def _words(self, number: int) -> tuple[int, ...]:
        entries = self.dictionary.tpdos[number].entries
        return tuple(self.value(entry.index, entry.sub) for entry in entries)


@dataclass
class Plug:
    """The CANopen plug of the gateway: what was sent, and whether the bus is disturbed."""

    outbox: list[Sent] = field(default_factory=list)
    """What is new, oldest first; whoever has put it on the bus clears the list."""
    fault: bool = False


@dataclass
class CanopenBus:
    """The CAN2 controller: once disturbed it is dead until it was initialised with success."""

    plug: Plug
    failed: bool = False
    """3072."""
    _age: int = 0

    @property
    def alive(self) -> bool:
        """Whether frames get in and out."""
        return not self.failed and not self.plug.fault

    def send(self, message: Sent) -> None:
        """Send, or lose the message."""
        if self.alive:
            self.plug.outbox.append(message)

    def step(self) -> None:
        """One main cycle: notice a fault; initialise again every half second."""
        if not self.failed:
            self.failed, self._age = self.plug.fault, 0
            return
        self._age += 1
        if self._age == RETRY_CYCLES:
            self.failed, self._age = self.plug.fault, 0


class CanopenSide:
    """Which service works is decided by the state machine and by the health of the bus."""

    def __init__(
        self,
        plug: Plug,
        settings: Store,
        assignment: Assignment,
        first: FirstTpdo,
        *,
        always_armed: bool,
    ) -> None:
        self.bus = CanopenBus(plug)
        self.outputs: Outputs | None = None
        """The values of the object dictionary, while there is one."""
        self.state = GatewayState.UNDEFINED
        """Of the state machine (3)."""
        self._assignment, self._first = assignment, first
        self._digital = (0, 0)  # errors and engine state, told even before there is a dictionary
        self._sent: dict[int, tuple[int, ...]] = {}  # of the binary TPDOs; outlives the dictionary
        self._beats = bool(settings[HEARTBEAT_PERIOD])
        limit = heartbeat_cycles(settings[HEARTBEAT_LIMIT])
        self.partner = Watch(limit if settings[PARTNER_NODE] else 0)
        """In Operational; without a first heartbeat it is not missed, or at once (A-19)."""
        self._always_armed = always_armed
        self.at_rest = False
        """Whether somebody else knows what the governor sends, and when."""

    @property
    def listening(self) -> bool:
        """Whether NMT is heard; the other services depend on the state."""
        return self.state in COMMUNICATING and self.bus.alive

    @property
    def operational(self) -> bool:
        """Whether PDOs are exchanged."""
        return self.state is GatewayState.OPERATIONAL and self.bus.alive

    def handle(self, trigger: Trigger) -> None:
        """Go where the trigger leads; Undefined and Init end the object dictionary."""
        before = self.state
        self.state = NEXT[before].get(trigger, before)
        if self.state is before:
            return
        if self.state not in COMMUNICATING:
            self.outputs = None
        if self.state is GatewayState.OPERATIONAL:
            self.partner.begin()
            if self.outputs is not None:
                self.outputs.begin()

    def create(self, dictionary: Dictionary) -> None:
        """The init telegrams were accepted: there is a dictionary now."""
        self.outputs = Outputs(dictionary, self._assignment, self._first, self._sent, self._digital)

    def boot_up(self) -> None:
        """Pre-Operational was entered from Init."""
        self.bus.send(BootUp())

    def step(self) -> None:
        """One main cycle: the partner's heartbeat, and the health of the bus."""
        if self._waits_for_partner:
            self.partner.step()
        failed = self.bus.failed
        self.bus.step()
        if failed and not self.bus.failed and self.state in COMMUNICATING:
            self.bus.send(Heartbeat(self.state) if self._beats else BootUp())

    @property
    def watches(self) -> bool:
        """Whether the partner can be missed."""
        return bool(self.partner.limit)

    @property
    def patience(self) -> int:
        """Main cycles until the partner is missed."""
        return self.partner.patience if self._waits_for_partner else NEVER

    def leap(self, cycles: int) -> None:
        """So many main cycles without a heartbeat of the partner, and with a sound bus."""
        if self._waits_for_partner:
            self.partner.leap(cycles)

    @property
    def _waits_for_partner(self) -> bool:
        armed = self._always_armed or self.partner.arrived
        return self.state is GatewayState.OPERATIONAL and armed

    def partner_heartbeat(self) -> None:
        """A heartbeat of the watched partner, its boot-up included (A-19)."""
        if self.bus.alive:
            self.partner.receive()

    def mapped(self, rpdo: int) -> tuple[Entry, ...]:
        """The entries of an RPDO 1..4 that is taken; none if it is not active, or nothing is."""
        if self.outputs is None or not self.operational:
            return ()
        pdo = self.outputs.dictionary.rpdos.get(rpdo)
        return () if pdo is None else pdo.entries

    def show(self, present: int, engine: int) -> None:
        """Errors and engine state of this cycle of the governor."""
        self._digital = present, engine
        if self.outputs is None:
            return
        self.outputs.show(present, engine)
        if self.operational:
            for frame in self.outputs.news():
                self.bus.send(frame)

    def take_tpdo(self, number: int, words: tuple[int, ...]) -> None:
        """An analogue TPDO of the governor: keep its values, and send it on if it is not known."""
        if self.outputs is None:
            return
        self.outputs.take(self.outputs.dictionary.tpdos[number].entries, words)
        if not self.at_rest:
            self.send_tpdo(TpdoFrame(number, words))

    def send_tpdo(self, frame: TpdoFrame) -> None:
        """Send an analogue TPDO of the governor on, in Operational."""
        if self.operational:
            self.bus.send(frame)


HELD = attrgetter(
    *("state", "outputs", "bus.failed", "bus.plug.fault"), *("partner.arrived", "partner.tripped")
)
"""What it depends on whether a telegram of the governor becomes a frame."""
