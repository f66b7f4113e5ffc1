"""What is left of a sequence of steps, and when it is over."""

from collections.abc import Callable, Iterator, Sequence

from canopen_twins.bus.clock import Clock, Timer, microseconds
from canopen_twins.scenario.player.turn import Turn
from canopen_twins.scenario.player.watch import GRAIN
from canopen_twins.scenario.player.window import Window
from canopen_twins.scenario.scenario import Step
from canopen_twins.scenario.verdict import Finding, Kind

UNDECIDED = Finding(Kind.ERROR, "the run ended before it was decided")
PATIENCE = 60.0  # seconds; as long as it takes to start a master by hand


class Agenda:
    """Calls `end` once nothing is left, or nothing that time alone would bring on.

    What is left then are conditions that have not been met, and windows that only the end closes.
    Conditions are waited for another minute, or for the duration if one is given.
    """

    def __init__(self, turns: Sequence[Turn], clock: Clock, end: Callable[[], None]) -> None:
        self.turns = dict.fromkeys(turns)
        """Those that are not over, in their order."""
        self.windows: list[Window] = []
        """Those that are not decided."""
        self.horizon = 0
        """The last microsecond of all that is known to come, of windows even if decided."""
        self._lasts = 0  # not over before this microsecond
        self._patience = 0  # microseconds
        self._clock = clock
        self._end = end
        self._busy: set[Turn] = set()  # time alone brings them on
        self._timer: Timer | None = None

    def begin(self, duration: float | None) -> None:
        """From now on, at least so many seconds; None: as long as it takes."""
        self.horizon = self._lasts = self._clock.ticks
        self._patience = microseconds(PATIENCE) if duration is None else 0
        if duration:
            self.last_until(self._clock.ticks + microseconds(duration))

    def last_until(self, tick: int) -> None:
        """It is not over before the end of a microsecond."""
        self._lasts = max(self._lasts, tick + GRAIN)
        self.reach(tick)

    def reach(self, tick: int) -> None:
        """Something may still come then."""
        self.horizon = max(self.horizon, tick)

    def expect(self, turn: Turn) -> None:
        """Time alone brings a turn on, from now on."""
        self._busy.add(turn)

    def cross_off(self, turn: Turn) -> None:
        """A turn is over."""
        self._busy.discard(turn)
        self.turns.pop(turn, None)

    @property
    def settled(self) -> bool:
        """Whether nothing is left to be done or decided."""
        return not self.turns and not self.windows and self._clock.ticks >= self._lasts

    @property
    def undecided(self) -> Iterator[tuple[Step, Finding]]:
        """What would be said of what is left if the run ended now."""
        for window in self.windows:
            yield window.step, UNDECIDED
        missed = [turn.step for turn in self.turns if not turn.begun]
        yield from ((turn.step, UNDECIDED) for turn in self.turns if turn.begun)
        if missed:
            text = f"{len(missed)} steps from here on were not reached"
            yield missed[0], Finding(Kind.ERROR, text)

    def settle(self) -> None:
        """If only the end is left to wait for, wait for it."""
        if self._timer is not None:
            self._timer.cancel()
        if not self._moves:
            self._timer = self._clock.at_tick(max(self._due, self._clock.ticks), self._look)

    @property
    def _due(self) -> int:
        """The microsecond of the end, if nothing comes in between."""
        last = self.horizon if self.turns or self.windows else self._clock.ticks
        patience = self._patience if self._waits else 0
        return max(last + GRAIN + patience, self._lasts)

    @property
    def _waits(self) -> bool:
        """Whether a condition may still bring something on."""
        return any(turn.waiting for turn in self.turns) or any(
            window.waits for window in self.windows
        )

    @property
    def _moves(self) -> bool:
        return bool(self._busy) or any(window.last is not None for window in self.windows)

    def _look(self) -> None:
        self._timer = None
        if not self._moves:
            self._end()
