"""Frames of the gateway beside SDO and NMT: PDOs, partner's heartbeat, end of a bus fault."""

import struct
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import MICROSECONDS, Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.devices.gateway.model.canopen_side import BootUp, Heartbeat, Sent, TpdoFrame
from canopen_twins.devices.gateway.model.state import GatewayState
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.devices.gateway.model.timing import GATEWAY_CYCLE, NEVER
from canopen_twins.slave.nmt import STATE_BYTE
from canopen_twins.slave.object import Address
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

STATES: Mapping[GatewayState, State] = {
    GatewayState.PRE_OPERATIONAL: State.PRE_OPERATIONAL,
    GatewayState.OPERATIONAL: State.OPERATIONAL,
    GatewayState.STOPPED: State.STOPPED,
}
WORD = 0xFFFF
FLAG_WORD = 2  # word 3 of RPDO1 (4.2.1)


MAIN_CYCLE = GATEWAY_CYCLE / MICROSECONDS  # seconds


@dataclass
class Disturbance:
    """What happens to frames before they reach the gateway."""

    lost: set[int] = field(default_factory=set)
    """RPDOs that do not arrive."""
    flagged: set[int] = field(default_factory=set)
    """Channels whose bits are set in word 3 of RPDO1, whatever the master sends there."""
    partner: bool = False
    """Whether heartbeats of the partner do not arrive."""


class Traffic(Service):
    """Brings frames to the model and its messages to the bus; shut while the bus is disturbed."""

    def __init__(
        self,
        slave: Slave,
        system: System,
        partner: int,
        disturbance: Disturbance,
        measured: Collection[Address] = (),
    ) -> None:
        """`measured`: what TPDOs tell as the dictionary shows it, not as the model knows it."""
        super().__init__(slave)
        self._system, self._partner, self._disturbance = system, partner, disturbance
        known = system.dictionary
        self._rpdos = {n: pdo.identifier for n, pdo in known.rpdos.items()} if known else {}
        self._tpdos = {n: pdo.identifier for n, pdo in known.tpdos.items()} if known else {}
        self._told = known.tpdos if known else {}
        self._measured = frozenset(measured)
        self._framed: dict[int, tuple[TpdoFrame, Frame]] = {}  # the last of each, as it was sent
        self._heartbeats = identifiers.heartbeat(slave.node_id)
        self._late: dict[type[Sent] | int, Sent] = {}  # the newest of each, while time is made up
        self._timer: Timer | None = None
        self._due = NEVER  # microsecond of the clock

    def begin(self) -> None:
        """The slave boots: what the model has sent so far, its own boot-up message has told."""
        self._system.outbox.clear()
        self._system.settled.is_asked = not self._measured
        self.publish()

    @property
    def eventful(self) -> bool:
        """The model may have sent something in every step."""
        return True

    def listen(self) -> Listening:
        """RPDOs that are active, and the watched partner."""
        for number, identifier in self._rpdos.items():
            yield (identifier, False), partial(self._on_rpdo, number)
        if self._partner in identifiers.NODE_IDS:
            yield (identifiers.heartbeat(self._partner), False), self._on_partner

    def publish(self) -> None:
        """Send what the model has sent, if it gets out."""
        self.slave.shut = not self._system.listening
        self._empty_outbox()
        self._await_tpdos()

    def _await_tpdos(self) -> None:
        """Those of a model at rest come without a step of it: the clock says when."""
        settled = self._system.settled
        due = settled.next_tpdos if settled.repeats and settled.leaps() else NEVER
        begin = self.slave.stepped() - self._system.now  # of the model, by the clock
        if due + begin == self._due:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._timer, self._due = None, due + begin
        if due < NEVER:
            self._timer = self.slave.clock.series_alone(self._due, partial(self._on_due, begin))

    def _on_due(self, begin: int) -> int | None:
        settled = self._system.settled
        settled.tell(self._due - begin)
        self._empty_outbox()
        self._due = settled.next_tpdos + begin
        return self._due if settled.next_tpdos < NEVER else None

    def _empty_outbox(self) -> None:
        outbox = self._system.outbox
        late = self.slave.clock.behind > MAIN_CYCLE
        if self._late and not late:
            self._send(self._late.values())
            self._late.clear()
        if outbox and late:
            self._late |= {_kind(message): message for message in outbox}
        elif outbox:
            self._send(outbox)
        outbox.clear()

    def _send(self, messages: Iterable[Sent]) -> None:
        for message in messages:
            self.slave.send(self._frame(message))

    def _frame(self, message: Sent) -> Frame:
        match message:
            case TpdoFrame():
                return self._tpdo(message)
            case Heartbeat(state):
                return Frame(self._heartbeats, bytes([STATE_BYTE[STATES[state]]]))
            case BootUp():
                return Frame(self._heartbeats, b"\0")

    def _tpdo(self, message: TpdoFrame) -> Frame:
        """A model at rest says the very same again and again: that is one frame."""
        number, words = message
        before = self._framed.get(number)
        if before is not None and before[0] is message:
            return before[1]
        shown = self._shown(number, words) if self._measured else words
        frame = Frame(self._tpdos[number], struct.pack(f"<{len(shown)}H", *shown))
        if not self._measured:
            self._framed[number] = message, frame
        return frame

    def _shown(self, number: int, words: Sequence[int]) -> Sequence[int]:
        """What a master would read at this moment, where it is measured."""
        addresses = [(entry.index, entry.sub) for entry in self._told[number].entries]
        return [
            self.slave.number(*address) & WORD if address in self._measured else word
            for address, word in zip(addresses, words, strict=True)
        ]

    def _on_rpdo(self, number: int, frame: Frame) -> None:
        if number in self._disturbance.lost:
            return
        words = list(struct.unpack_from(f"<{len(frame.data) // 2}H", frame.data))
        if number == 1 and len(words) > FLAG_WORD:
            words[FLAG_WORD] |= sum(1 << (channel - 1) for channel in self._disturbance.flagged)
        self._system.receive_rpdo(number, tuple(words))

    def _on_partner(self, frame: Frame) -> None:
        if len(frame.data) == 1 and not self._disturbance.partner:
            self._system.partner_heartbeat()


def _kind(message: Sent) -> type[Sent] | int:
    """What an older one is the same as: a TPDO by its number."""
    return message.number if isinstance(message, TpdoFrame) else type(message)
