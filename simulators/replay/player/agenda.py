"""What is left of a sequence of steps, and when it is over."""

from collections.abc import Callable, Iterator, Sequence

from simulators.clock import Clock, Timer, microseconds
from simulators.replay.player.turn import Turn
from simulators.replay.player.watch import GRAIN
from simulators.replay.player.window import Window
from simulators.replay.scenario import Step
from simulators.replay.verdict import Finding, Kind

UNDECIDED = Finding(Kind.ERROR, "the run ended before it was decided")


class Agenda:
    """Calls `end` once nothing is left, or nothing that time alone would bring on.

    What is left then are conditions that have not been met, and windows that only the end closes.
    """

    def __init__(self, turns: Sequence[Turn], clock: Clock, end: Callable[[], None]) -> None:
        self.turns = dict.fromkeys(turns)
        """Those that are not over, in their order."""
        self.windows: list[Window] = []
        """Those that are not decided."""
        self.horizon = 0
        """The last microsecond of all that is known to come, of windows even if decided."""
        self._lasts = 0  # not over before this microsecond
        self._clock = clock
        self._end = end
        self._busy: set[Turn] = set()  # time alone brings them on
        self._timer: Timer | None = None

    def begin(self, duration: float) -> None:
        """From now on, at least so many seconds."""
        self.horizon = self._lasts = self._clock.ticks
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
        if self._timer is None and not self._moves:
            last = self.horizon if self.turns or self.windows else self._clock.ticks
            tick = max(last + GRAIN, self._lasts, self._clock.ticks)
            self._timer = self._clock.at_tick(tick, self._look)

    @property
    def _moves(self) -> bool:
        return bool(self._busy) or any(window.last is not None for window in self.windows)

    def _look(self) -> None:
        self._timer = None
        if self._moves or self._clock.ticks < self._lasts:
            self.settle()
        else:
            self._end()
