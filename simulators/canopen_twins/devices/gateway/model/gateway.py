"""Gateway, the control unit of type CM: obeys master and governor, and carries PDOs over."""

from functools import partial
from operator import attrgetter
from typing import Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.buffers import OVERFLOW, Buffer, ReceiveBuffer
from canopen_twins.devices.gateway.model.canopen_side import CanopenSide, Plug
from canopen_twins.devices.gateway.model.desk import Desk
from canopen_twins.devices.gateway.model.errors import OF_GATEWAY, CanopenError
from canopen_twins.devices.gateway.model.handshake import Initialisation
from canopen_twins.devices.gateway.model.heinzmann_can import (
    SHOWN,
    Binary,
    ClearErrors,
    Command,
    GatewayAlive,
    GovernorAlive,
    HeinzmannCan,
    InitData,
    InitEnd,
    RpdoData,
    Telegram,
    TpdoData,
)
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.state import GatewayState, MasterCommand, Trigger, Trouble
from canopen_twins.devices.gateway.model.timing import GATEWAY_CYCLE
from canopen_twins.devices.gateway.model.unit import ControlUnit, Programme, Surroundings

FATAL = errors.bits(errors.FATAL)
CANOPEN_BUS_ERROR = errors.bit(errors.CAN_BUS_2)


class GatewayProgramme(Programme):
    """`tick` is the order of a main cycle; everything else is handled when it arrives."""

    def __init__(self, unit: ControlUnit[Any], plug: Plug, around: Surroundings) -> None:
        can = HeinzmannCan(unit.wiring, unit.store, partner=402, enable=4400)  # 7.2.1
        super().__init__(unit, can, OF_GATEWAY)
        options = around.options
        self.canopen = CanopenSide(
            plug,
            unit.store,
            around.tables.assignment,
            options.first_tpdo,
            always_armed=options.always_armed,
        )
        self._initialisation = Initialisation(unit.store, self.canopen, self.errors, can.send)
        self._received = ReceiveBuffer(ideal=options.answer_time == 0)
        self._blocked = False  # 9.4: Undefined until a reset
        self._told: tuple[GatewayState, int, bool, CanopenError] | None = None
        self.live |= {number: partial(self.can.shows, number) for number in SHOWN}
        self.live |= {
            2405: lambda: int(self.can.connected),
            12405: lambda: int(self.canopen.bus.alive and not self._blocked),
        }

    @property
    def state(self) -> GatewayState:
        """The CANopen state machine."""
        return self.canopen.state

    @property
    def causes(self) -> int:
        """What is wrong at this moment: the CANopen bus as well."""
        causes = super().causes
        return causes | CANOPEN_BUS_ERROR if self.canopen.bus.failed else causes

    @property
    def _ready(self) -> bool:
        return not (self._blocked or self.link_failed)

    def command(self, command: MasterCommand) -> None:
        """An NMT command of the master to this node or to all."""
        if self.canopen.listening:
            self._enter(command)
            self._tell_change()

    def receive_rpdo(self, number: int, words: tuple[int, ...]) -> None:
        """An RPDO 1..4 of the master; one that is too short is ignored (A-30)."""
        entries, outputs = self.canopen.mapped(number), self.canopen.outputs
        if self._overrun():
            return
        if outputs is not None and 0 < len(entries) <= len(words):
            mapped = words[: len(entries)]
            outputs.take(entries, mapped)
            self.can.send(RpdoData(number, mapped))

    def partner_heartbeat(self) -> None:
        """A heartbeat or boot-up message of node 428."""
        if not self._overrun():
            self.canopen.partner_heartbeat()

    def _overrun(self) -> bool:
        overrun = self._received.receive()
        if overrun:
            self.overflow(Buffer.CAN2_RECEIVE)
        return overrun

    def overflow(self, buffer: Buffer) -> None:
        """A buffer has overflowed and is cleared: 3071 or 3073 is reported for a moment."""
        error, consequence = OVERFLOW[buffer]
        self._received.clear()
        self._pulses |= errors.bit(error)
        self.evaluate()
        self._enter(consequence)
        self._tell_change()

    def tick(self) -> None:
        """One main cycle."""
        self._received.clear()
        self.canopen.step()
        self.errors.follow(CanopenError.HEARTBEAT, self.canopen.partner.tripped)
        self._pulses = 0
        self.evaluate()
        self._blocked = self._blocked or bool(self.unit.memory.present & FATAL)
        if not self._ready:
            self._enter(Trouble.ABORT)
        if self.canopen.bus.failed:
            self._enter(Trouble.CANOPEN_BUS)
        if self.alive_due:
            self._told = None
        self._tell_change()
        self._cycles += 1

    def clear(self) -> None:
        """Clear all errors here."""
        self.canopen.partner.tripped = False
        super().clear()
        self._told = None  # the governor has forgotten, too, what we told it

    def handle(self, telegram: Telegram) -> None:
        """Act on a telegram of the governor."""
        match telegram.body:  # the most frequent first
            case Binary(present, engine, told):
                self.errors.partner = told
                self.canopen.show(present | self.unit.memory.present, engine)
            case TpdoData(number, words):
                self.canopen.take_tpdo(number, words)
            case GovernorAlive(told):
                self.errors.partner = told
            case Command() as command:
                self._initialisation.obey(command, ready=self._ready)
            case InitData() as data:
                self._initialisation.collect(data)
            case InitEnd() as end:
                self._initialisation.judge(end)
            case ClearErrors():
                self.clear()
        self._tell_change()

    # At rest: see `settled`

    @property
    def is_steady(self) -> bool:
        """Whether the next main cycle does again what this one has done, as far as it knows."""
        return self._ready and self.canopen.listening and self.can.is_steady

    @property
    def patience(self) -> int:
        """Main cycles until the partner is missed; NEVER if it is not waited for."""
        return self.canopen.patience

    def leap(self, cycles: int, heard: int | None) -> None:
        """Main cycles at rest; the governor is heard at a moment, us, or not at all."""
        if cycles:
            self._received.clear()
        if heard is not None:
            self.can.hear(heard)
        self.canopen.leap(cycles)
        self._cycles += cycles

    def _enter(self, trigger: Trigger) -> None:
        before = self.state
        self.canopen.handle(trigger)
        if self.state is not before and self.state is GatewayState.OPERATIONAL:
            self.errors.clear(self.causes)

    def _tell_change(self) -> None:
        mine = self._initialisation
        content = (self.state, mine.session, self._ready, self.errors.own)
        if content != self._told:
            self._told = content
            self.can.send(GatewayAlive(*content, first=self._cycles == 0))


class Gateway(ControlUnit[GatewayProgramme]):
    """The control unit, with the CANopen plug."""

    which, partner = Unit.GATEWAY, Unit.GOVERNOR
    inner_faults = errors.FATAL

    def __init__(self, around: Surroundings) -> None:
        super().__init__(around, GATEWAY_CYCLE)
        self.desk = Desk(self, around.tables.catalogue)
        self.plug = Plug()
        self._around = around

    def start(self) -> GatewayProgramme:
        """The programme, as it begins."""
        return GatewayProgramme(self, self.plug, self._around)


HELD = attrgetter(
    *("_told", "_initialisation.session", "errors.own", "errors.partner"),
    *("_pulses", "_blocked"),
)
"""What the main cycles of a programme depend on."""
