"""The governor initialises its gateway: the asking half and the answering half (3, 7.3, 9.5).

    governor                           gateway
    Command(Init, session)         ->  Init; what is of another session is ignored from now on
                                   <-  InitReady
    InitData ... InitEnd(count)    ->  makes the object dictionary of it, or refuses
                                   <-  InitResult
    Command(Pre-Operational)       ->  Pre-Operational, boot-up message
                                   <-  GatewayAlive, which tells the state from then on

Up to three attempts are made, then the governor gives up.
"""

from collections.abc import Callable, Mapping, Sequence
from enum import Enum

from canopen_twins.devices.gateway.model.canopen_side import CanopenSide
from canopen_twins.devices.gateway.model.configuration import InitPart, Refusal, built, refusal
from canopen_twins.devices.gateway.model.errors import CanopenError, CanopenErrors
from canopen_twins.devices.gateway.model.heinzmann_can import (
    Body,
    Command,
    GatewayAlive,
    InitData,
    InitEnd,
    InitReady,
    InitResult,
)
from canopen_twins.devices.gateway.model.parameters import Store
from canopen_twins.devices.gateway.model.state import COMMUNICATING, GatewayState, GovernorCommand
from canopen_twins.devices.gateway.model.timing import MILLISECOND, Time

ATTEMPTS = 3  # 9.5
STEP_TIME = 250 * MILLISECOND  # A-24, for each answer
PAUSE = 100 * MILLISECOND  # A-24, between two attempts


class Phase(Enum):
    """Where the procedure stands."""

    WAIT = "no gateway is heard"
    PAUSE = "the next attempt is due soon"
    READY = "Init is ordered"
    RESULT = "the configuration is sent"
    PREOP = "Pre-Operational is ordered"
    RUN = "the gateway communicates"
    FAILED = "three attempts have failed"


class Progress(Enum):
    """What leads from phase to phase."""

    HEARD = "the gateway is heard"
    START = "an attempt begins"
    READY = "the gateway is in Init"
    ACCEPTED = "the configuration is accepted"
    REACHED = "the gateway is in Pre-Operational"
    FAILED = "no answer in time, or a refusal"
    GIVEN_UP = "the third failure"
    AGAIN = "the gateway left, or errors were cleared"
    LOST = "the link is lost"


LOST: Mapping[Progress, Phase] = {Progress.LOST: Phase.WAIT}
FAILURE: Mapping[Progress, Phase] = {
    **LOST,
    Progress.FAILED: Phase.PAUSE,
    Progress.GIVEN_UP: Phase.FAILED,
}

# What a phase does not name changes nothing.
NEXT: Mapping[Phase, Mapping[Progress, Phase]] = {
    Phase.WAIT: {Progress.HEARD: Phase.PAUSE},
    Phase.PAUSE: {**LOST, Progress.START: Phase.READY},
    Phase.READY: {**FAILURE, Progress.READY: Phase.RESULT},
    Phase.RESULT: {**FAILURE, Progress.ACCEPTED: Phase.PREOP},
    Phase.PREOP: {**FAILURE, Progress.REACHED: Phase.RUN},
    Phase.RUN: {**LOST, Progress.AGAIN: Phase.PAUSE},
    Phase.FAILED: {**LOST, Progress.AGAIN: Phase.PAUSE},
}
UNDERWAY = (Phase.READY, Phase.RESULT, Phase.PREOP)


class Handshake:
    """The governor's side; the gateway answers. Every attempt is a session with a new number."""

    def __init__(self, time: Time, send: Callable[[Body], None], parts: Sequence[InitPart]) -> None:
        self._time, self._send, self._parts = time, send, parts
        self.phase = Phase.WAIT
        self.state = GatewayState.UNDEFINED
        """The governor's copy of the gateway's state."""
        self.fresh = True
        """Nothing says that the gateway was reset after this unit."""
        self.gateway: GatewayAlive | None = None
        """What it said last."""
        self.refusal: Refusal | None = None
        """Why it did not accept the configuration last time."""
        self._met = False  # a gateway was heard since the reset
        self._session = 0
        self._attempts = 0
        self._deadline = 0

    def heard(self, gateway: GatewayAlive) -> None:
        """The gateway tells its state; only what it says of the current session is believed."""
        before, self.gateway = self.gateway, gateway
        was_reset = gateway.first or (before is not None and gateway.epoch < before.epoch)
        if was_reset:
            self.state = GatewayState.UNDEFINED
            self.fresh = self.fresh and not self._met
        elif gateway.epoch == self._session:
            self.state = gateway.state
        self._met = True
        left = self.phase is Phase.RUN and self.state not in COMMUNICATING
        if was_reset or left:
            self._again()
        elif self.phase is Phase.PREOP and self.state in COMMUNICATING:
            self.fresh = False
            self._handle(Progress.REACHED)
        self._handle(Progress.HEARD)

    def ready(self, answer: InitReady) -> None:
        """The gateway waits for its configuration: send it."""
        if self.phase is Phase.READY and answer.session == self._session:
            self._handle(Progress.READY)
            for part in self._parts:
                self._send(InitData(self._session, part))
            self._send(InitEnd(self._session, len(self._parts)))

    def judged(self, answer: InitResult) -> None:
        """The gateway has checked the configuration."""
        if self.phase is not Phase.RESULT or answer.session != self._session:
            return
        self.refusal = answer.refusal
        if answer.refusal is not None:
            self._fail()
            return
        self._handle(Progress.ACCEPTED)
        self._command(GovernorCommand.PRE_OPERATIONAL)

    def step(self) -> None:
        """Once per main cycle: begin an attempt that is due, give up one that takes too long."""
        if self._time.now < self._deadline:
            return
        if self.phase in UNDERWAY:
            self._fail()
        elif self.phase is Phase.PAUSE and self.gateway is not None and self.gateway.ready:
            self._begin(self.gateway)

    def cleared(self) -> None:
        """All errors were cleared: there are three more attempts, if they were used up."""
        if self.phase is Phase.FAILED:
            self._again()

    def lost(self) -> None:
        """There is no communication with the gateway: order Undefined, in case it hears us."""
        if self.phase is Phase.WAIT:
            return
        self._command(GovernorCommand.UNDEFINED)
        self._session += 1  # what the gateway says of the session before is not believed
        self._attempts, self._deadline = 0, self._time.now
        self.state, self.gateway = GatewayState.UNDEFINED, None
        self._handle(Progress.LOST)

    def _again(self) -> None:
        if Progress.AGAIN in NEXT[self.phase]:
            self._attempts, self._deadline = 0, self._time.now
            self._handle(Progress.AGAIN)

    def _begin(self, gateway: GatewayAlive) -> None:
        self._attempts += 1
        self._session = max(self._session, gateway.epoch) + 1
        self._handle(Progress.START)
        self._command(GovernorCommand.INIT)

    def _fail(self) -> None:
        if self._attempts < ATTEMPTS:
            self._handle(Progress.FAILED)
            self._deadline = self._time.now + PAUSE
        else:
            self._handle(Progress.GIVEN_UP)
            self._command(GovernorCommand.UNDEFINED)

    def _command(self, command: GovernorCommand) -> None:
        self._send(Command(command, self._session, self.fresh))

    def _handle(self, progress: Progress) -> None:
        before = self.phase
        self.phase = NEXT[before].get(progress, before)
        if self.phase is not before and self.phase in UNDERWAY:
            self._deadline = self._time.now + STEP_TIME


class Initialisation:
    """The gateway's side: obeys the governor; what is of another session than Init is ignored."""

    def __init__(
        self,
        settings: Store,
        canopen: CanopenSide,
        errors: CanopenErrors,
        send: Callable[[Body], None],
    ) -> None:
        self._settings, self._canopen, self._errors, self._send = settings, canopen, errors, send
        self._parts: list[InitPart] = []
        self.session = 0
        """Of the governor's last Init; 0 before the first since the reset."""

    def obey(self, command: Command, *, ready: bool) -> None:
        """Enter what is ordered; ready: nothing is wrong here that forbids an initialisation."""
        match command.command:
            case GovernorCommand.INIT if ready:
                self._begin(command)
            case GovernorCommand.UNDEFINED:
                self._canopen.handle(command.command)
            case GovernorCommand.PRE_OPERATIONAL if self._accepted(command.session):
                self._canopen.handle(command.command)
                self._canopen.boot_up()

    def collect(self, data: InitData) -> None:
        """One piece of the configuration."""
        if self._underway(data.session):
            self._parts.append(data.part)

    def judge(self, end: InitEnd) -> None:
        """Create the dictionary, or tell what is wrong with structure or content (7.3)."""
        if not self._underway(end.session):
            return
        dictionary = built(self._parts, self._settings)
        complete = end.pieces == len(self._parts)
        wrong = refusal(dictionary, self._settings) if complete else Refusal.STRUCTURE
        if wrong is None:
            self._canopen.create(dictionary)
        self._send(InitResult(self.session, wrong))

    def _begin(self, command: Command) -> None:
        if self.session == 0 and not command.fresh:
            self._errors.own |= CanopenError.GW_RESET
        self.session, self._parts = command.session, []
        self._canopen.handle(command.command)
        self._send(InitReady(command.session))

    def _underway(self, session: int) -> bool:
        return self._canopen.state is GatewayState.INIT and session == self.session

    def _accepted(self, session: int) -> bool:
        return self._underway(session) and self._canopen.outputs is not None
