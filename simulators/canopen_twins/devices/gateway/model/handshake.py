"""How the governor initialises its gateway: up to three attempts, then it gives up (3, 9.5)."""

from collections.abc import Callable, Mapping, Sequence
from enum import Enum

from canopen_twins.devices.gateway.model.dictionary import Dictionary, built, refusal
from canopen_twins.devices.gateway.model.state import COMMUNICATING, GovernorCommand, State
from canopen_twins.devices.gateway.model.store import Store
from canopen_twins.devices.gateway.model.telegrams import (
    Body,
    Command,
    GatewayAlive,
    InitData,
    InitEnd,
    InitPart,
    InitReady,
    InitResult,
    Refusal,
)
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


class Event(Enum):
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


LOST: Mapping[Event, Phase] = {Event.LOST: Phase.WAIT}
FAILURE: Mapping[Event, Phase] = {
    **LOST,
    Event.FAILED: Phase.PAUSE,
    Event.GIVEN_UP: Phase.FAILED,
}

# An event that a phase does not name changes nothing.
NEXT: Mapping[Phase, Mapping[Event, Phase]] = {
    Phase.WAIT: {Event.HEARD: Phase.PAUSE},
    Phase.PAUSE: {**LOST, Event.START: Phase.READY},
    Phase.READY: {**FAILURE, Event.READY: Phase.RESULT},
    Phase.RESULT: {**FAILURE, Event.ACCEPTED: Phase.PREOP},
    Phase.PREOP: {**FAILURE, Event.REACHED: Phase.RUN},
    Phase.RUN: {**LOST, Event.AGAIN: Phase.PAUSE},
    Phase.FAILED: {**LOST, Event.AGAIN: Phase.PAUSE},
}
UNDERWAY = (Phase.READY, Phase.RESULT, Phase.PREOP)


class Handshake:
    """The governor's side; the gateway answers. Every attempt is a session with a new number."""

    def __init__(self, time: Time, send: Callable[[Body], None], parts: Sequence[InitPart]) -> None:
        self._time, self._send, self._parts = time, send, parts
        self.phase = Phase.WAIT
        self.state = State.UNDEFINED
        """The governor's copy of the gateway's state."""
        self.fresh = True
        """No initialisation has succeeded since the reset."""
        self.gateway: GatewayAlive | None = None
        """What it said last."""
        self.refusal: Refusal | None = None
        """Why it did not accept the configuration last time."""
        self._session = 0
        self._attempts = 0
        self._deadline = 0

    def heard(self, gateway: GatewayAlive) -> None:
        """The gateway tells its state; only what it says of the current session is believed."""
        before, self.gateway = self.gateway, gateway
        was_reset = gateway.first or (before is not None and gateway.epoch < before.epoch)
        if was_reset:
            self.state = State.UNDEFINED
        elif gateway.epoch == self._session:
            self.state = gateway.state
        left = self.phase is Phase.RUN and self.state not in COMMUNICATING
        if was_reset or left:
            self._again()
        elif self.phase is Phase.PREOP and self.state in COMMUNICATING:
            self.fresh = False
            self._handle(Event.REACHED)
        self._handle(Event.HEARD)

    def ready(self, answer: InitReady) -> None:
        """The gateway waits for its configuration: send it."""
        if self.phase is Phase.READY and answer.session == self._session:
            self._handle(Event.READY)
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
        self._handle(Event.ACCEPTED)
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
        self.state, self.gateway = State.UNDEFINED, None
        self._handle(Event.LOST)

    def _again(self) -> None:
        if Event.AGAIN in NEXT[self.phase]:
            self._attempts, self._deadline = 0, self._time.now
            self._handle(Event.AGAIN)

    def _begin(self, gateway: GatewayAlive) -> None:
        self._attempts += 1
        self._session = max(self._session, gateway.epoch) + 1
        self._handle(Event.START)
        self._command(GovernorCommand.INIT)

    def _fail(self) -> None:
        if self._attempts < ATTEMPTS:
            self._handle(Event.FAILED)
            self._deadline = self._time.now + PAUSE
        else:
            self._handle(Event.GIVEN_UP)
            self._command(GovernorCommand.UNDEFINED)

    def _command(self, command: GovernorCommand) -> None:
        self._send(Command(command, self._session, self.fresh))

    def _handle(self, event: Event) -> None:
        before = self.phase
        self.phase = NEXT[before].get(event, before)
        if self.phase is not before and self.phase in UNDERWAY:
            self._deadline = self._time.now + STEP_TIME


class Initialisation:
    """What is of another session than the current one is ignored by whoever calls."""

    def __init__(self, settings: Store) -> None:
        self._settings = settings
        self._parts: list[InitPart] = []
        self.session = 0
        """Of the governor's last Init; 0 before the first."""
        self.fresh = True
        """No initialisation has succeeded since the reset."""

    def begin(self, session: int) -> None:
        """The governor has ordered Init."""
        self.session, self._parts = session, []

    def collect(self, data: InitData) -> None:
        """One piece of the configuration."""
        self._parts.append(data.part)

    def judge(self, count: int) -> Dictionary | Refusal:
        """The dictionary, or what is wrong with structure or content (7.3)."""
        if count != len(self._parts):
            return Refusal.STRUCTURE
        dictionary = built(self._parts, self._settings)
        return refusal(dictionary, self._settings) or dictionary
