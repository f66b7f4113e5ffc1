"""Programme of the gateway: two sources of commands, the dialogue with the governor, and errors."""

from functools import partial
from typing import Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.assignment import Assignment
from canopen_twins.devices.gateway.model.canopen_errors import OF_GATEWAY, CanopenError
from canopen_twins.devices.gateway.model.canopen_side import CanopenSide, Outputs, Plug
from canopen_twins.devices.gateway.model.handshake import Initialisation
from canopen_twins.devices.gateway.model.heinzmann_can import SHOWN, Numbers
from canopen_twins.devices.gateway.model.options import Options
from canopen_twins.devices.gateway.model.programme import Programme
from canopen_twins.devices.gateway.model.state import (
    COMMUNICATING,
    GovernorCommand,
    Machine,
    MasterCommand,
    State,
    Trigger,
    Trouble,
)
from canopen_twins.devices.gateway.model.telegrams import (
    Binary,
    ClearErrors,
    Command,
    GatewayAlive,
    GovernorAlive,
    InitData,
    InitEnd,
    InitReady,
    InitResult,
    Refusal,
    RpdoData,
    Telegram,
    TpdoData,
)
from canopen_twins.devices.gateway.model.unit import ControlUnit

NUMBERS = Numbers(partner=402, enable=4400)  # 7.2.1
FATAL = errors.bits(errors.FATAL)
CANOPEN_BUS_ERROR = errors.bit(errors.CAN_BUS_2)


class GatewayProgramme(Programme):
    """`tick` is the order of a main cycle; everything else is handled when it arrives."""

    def __init__(
        self, unit: ControlUnit[Any], plug: Plug, assignment: Assignment, options: Options
    ) -> None:
        super().__init__(unit, NUMBERS, OF_GATEWAY)
        self._machine = Machine()
        self.canopen = CanopenSide(
            plug, self._machine, unit.store, unit.cycle, always_armed=options.always_armed
        )
        self._initialisation = Initialisation(unit.store)
        self._assignment, self._first = assignment, options.first_tpdo
        self._blocked = False  # 9.4: Undefined until a reset
        self._told: tuple[State, int, bool, bool, CanopenError] | None = None
        self.live |= {number: partial(self.can.shows, number) for number in SHOWN}
        self.live |= {
            2405: lambda: int(self.can.connected),
            12405: lambda: int(self.canopen.bus.alive and not self._blocked),
        }

    @property
    def state(self) -> State:
        """The CANopen state machine."""
        return self._machine.state

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
        if outputs is not None and 0 < len(entries) <= len(words):
            mapped = words[: len(entries)]
            outputs.take(entries, mapped)
            self.can.send(RpdoData(number, mapped))

    def overflow(self, error: int, consequence: Trouble) -> None:
        """A buffer has overflowed and was cleared: 3071 or 3073 is reported for a moment."""
        self._pulses |= errors.bit(error)
        self.evaluate()
        self._enter(consequence)
        self._tell_change()

    def tick(self) -> None:
        """One main cycle."""
        self.canopen.step()
        self.errors.follow(CanopenError.HEARTBEAT, self.canopen.consumer.tripped)
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
        self.canopen.consumer.tripped = False
        super().clear()
        self._told = None  # the governor has forgotten, too, what we told it

    def handle(self, telegram: Telegram) -> None:
        """Act on a telegram of the governor."""
        match telegram.body:  # the most frequent first
            case Binary(present, engine, told):
                self.errors.partner = told
                self.canopen.show(present | self.unit.memory.present, engine)
            case TpdoData(number, words):
                self.canopen.send_tpdo(number, words)
            case GovernorAlive(told):
                self.errors.partner = told
            case Command() as command:
                self._obey(command)
            case InitData() as data if self._initialising(data.session):
                self._initialisation.collect(data)
            case InitEnd(session, count) if self._initialising(session):
                self._judge(count)
            case ClearErrors():
                self.clear()
        self._tell_change()

    def _obey(self, command: Command) -> None:
        match command.command:
            case GovernorCommand.INIT if self._ready:
                self._begin(command)
            case GovernorCommand.UNDEFINED:
                self._enter(command.command)
            case GovernorCommand.PRE_OPERATIONAL if self._accepted(command.session):
                self._initialisation.fresh = False
                self._enter(command.command)
                self.canopen.boot_up()

    def _begin(self, command: Command) -> None:
        if self._initialisation.fresh and not command.fresh:
            self.errors.own |= CanopenError.GW_RESET
        self._initialisation.begin(command.session)
        self._enter(command.command)
        self.can.send(InitReady(command.session))

    def _initialising(self, session: int) -> bool:
        return self.state is State.INIT and session == self._initialisation.session

    def _accepted(self, session: int) -> bool:
        return self._initialising(session) and self.canopen.outputs is not None

    def _judge(self, count: int) -> None:
        match self._initialisation.judge(count):
            case Refusal() as refusal:
                self.can.send(InitResult(self._initialisation.session, refusal))
            case dictionary:
                self.canopen.create(Outputs(dictionary, self._assignment, self._first))
                self.can.send(InitResult(self._initialisation.session, None))

    def _enter(self, trigger: Trigger) -> None:
        before = self.state
        self._machine.handle(trigger)
        if self.state is before:
            return
        if self.state not in COMMUNICATING:
            self.canopen.outputs = None
        if self.state is State.OPERATIONAL:
            self.canopen.begin_operation()
            self.errors.clear(self.causes)

    def _tell_change(self) -> None:
        mine = self._initialisation
        content = (self.state, mine.session, mine.fresh, self._ready, self.errors.own)
        if content != self._told:
            self._told = content
            self.can.send(GatewayAlive(*content, first=self._cycles == 0))
