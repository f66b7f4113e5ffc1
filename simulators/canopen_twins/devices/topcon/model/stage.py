"""The output stage: power side and protections in one state machine, in ticks of 1 ms."""

from dataclasses import fields
from math import ceil, inf
from operator import attrgetter
from typing import Any

from canopen_twins.devices.topcon.model.plant import Inputs, Plant
from canopen_twins.devices.topcon.model.protections import Latches
from canopen_twins.devices.topcon.model.states import TRANSITIONS, Mode, StageEvent, StageState

LAST_ERROR = 0x1FF  # error numbers of chapter 8 have nine bits

inputs_of = attrgetter(*(part.name for part in fields(Inputs)))


class OutputStage(Plant):
    """Set values and surroundings are assigned: see `Inputs`. It is made with its supply on."""

    def power_off(self) -> None:
        """Supply goes, and the output with it; time passes in `drain` from here."""
        self.state = StageState.POWERUP
        self.circuit.disturb()

    def power_on(self) -> None:
        """Supply comes: nothing is latched, and voltage, heat and load are what they are."""
        self._supply()
        self.circuit.disturb()

    def _supply(self) -> None:
        super()._supply()
        self._latches = Latches(self, self.tick)
        self._boot_ticks = ceil(self.boot_time / self.tick - 1e-6)
        self._owed = 0.0  # ticks gone by that have not been simulated
        self._calm: Any = None  # the inputs, when with them nothing happens for the time `_ahead`
        self._ahead = 0.0
        if not self._boot_left:
            self._fire(StageEvent.BOOTED)

    @property
    def errors(self) -> tuple[int, ...]:
        """Error numbers in the order they came, latched until reset."""
        return tuple(self._latches.errors)

    @property
    def warning(self) -> bool:
        """Latched as an error is, but the output stays on (A-53)."""
        return self._latches.warning

    @property
    def blocked(self) -> bool:
        """Whether `run` would do nothing: powering up, error, open interlock."""
        return self.state in (StageState.POWERUP, StageState.ERROR) or not self.interlock_closed

    def run(self) -> None:
        """Output on, from zero. Nothing while blocked (A-47), or when it is on already."""
        if not self.blocked and not self.running:
            self.ramps.restart()
            self.circuit.mode = Mode.VOLTAGE
            self._fire(StageEvent.RUN)
            self._follow_latches()

    def stop(self) -> None:
        """Output off, at once."""
        self._fire(StageEvent.STOP)

    def reset(self) -> None:
        """Forget errors and warning as far as their cause is gone (A-49); starts nothing."""
        self._latches.reset(self)
        if not self.errors:
            self._fire(StageEvent.CLEAR)
        self._follow_latches()

    def trip(self, error: int, held: bool = False) -> None:
        """Raise an error from outside; when held, its cause lasts until `release`.

        Raises ValueError for a number of more than nine bits (chapter 8).
        """
        if not 0 <= error <= LAST_ERROR:
            raise ValueError(f"error number {error:#x} is not in 0..{LAST_ERROR:#x}")
        if held:
            self._latches.hold(error)
        self._latches.latch(error)
        self._follow_latches()

    def release(self, error: int) -> None:
        """End the cause of a held error; the error itself waits for a reset."""
        self._latches.release(error)

    def warn(self) -> None:
        """Raise the warning from outside."""
        self._latches.warning = True
        self._follow_latches()

    @property
    def rest(self) -> float:
        """Seconds that need no step: 0 while something moves, inf if nothing ever will again."""
        if self._calm is None or self.load is not self.circuit.load:
            return 0.0
        if self._calm != inputs_of(self):
            return 0.0
        return self._ahead

    def step(self, dt: float) -> None:
        """`dt` seconds, of any length; what is less than a tick waits for the next call."""
        self._owed += dt / self.tick
        while (due := int(self._owed + 1e-6)) > 0:
            rest = self.rest
            ticks = max(1, ceil(min(rest / self.tick, due) - 1e-6)) if rest else 1
            self._owed -= ticks
            if rest and self.settled:
                self.coast(ticks)
                self._ahead = rest - ticks * self.tick
                if self._ahead > 1e-6 * self.tick:
                    continue  # what is watched cannot have changed before that time is over
            else:
                self.flow(ticks)
            self._supervise()
            self.mains_before = self.mains
            self._look_ahead()

    def _look_ahead(self) -> None:
        undisturbed = 0.0 if self._latches.pending else self.ahead
        if undisturbed:
            self._ahead, self._calm = min(undisturbed, self._boot_left or inf), inputs_of(self)
        else:
            self._calm = None

    def _supervise(self) -> None:
        if self.state is StageState.POWERUP:
            if not self._boot_left:
                self._fire(StageEvent.BOOTED)
            return
        self._latches.step(self)
        self._follow_latches()

    @property
    def _boot_left(self) -> float:
        return max(0, self._boot_ticks - self.ticks) * self.tick

    def _follow_latches(self) -> None:
        if self._latches.errors:
            self._fire(StageEvent.TRIP)
        if self._latches.warning:
            self._fire(StageEvent.WARN)

    def _fire(self, event: StageEvent) -> None:
        state, was_running = TRANSITIONS[self.state].get(event), self.running
        if state is None:
            return
        self.state = state
        if self.running is not was_running:
            self.circuit.disturb()
            self._calm = None
