"""Steps one after the other, each at its moment, until the last expectation is decided."""

from collections.abc import Callable, Iterator
from collections.abc import Sequence as Steps

from simulators.clock import Timer, microseconds
from simulators.replay.expect import Expectation
from simulators.replay.player.crew import Crew
from simulators.replay.player.senses import Position
from simulators.replay.player.turn import WHOLE_MOMENT, Turn
from simulators.replay.player.watch import GRAIN
from simulators.replay.player.window import Window
from simulators.replay.scenario import After, At, Condition, Step
from simulators.replay.verdict import Finding, Kind

UNDECIDED = Finding(Kind.ERROR, "the run ended before it was decided")
NEVER_CAME = Finding(Kind.ERROR, "its moment never came")


class Course:
    """Calls `over` when its time is, which is not before `duration` in seconds is over.

    What is not decided by time alone is decided then: a condition that has not been met, an
    expectation for the whole run. With `strict`, the first error ends it, too.
    """

    def __init__(
        self,
        steps: Steps[Step],
        crew: Crew,
        over: Callable[[], None],
        duration: float = 0.0,
        strict: bool = True,
    ) -> None:
        self.over = False
        self._crew = crew
        self._clock = crew.clock
        self._tell_over = over
        self._duration = duration
        self._strict = strict
        self._turns = [Turn(step, crew, self) for step in steps]
        self._after = dict(zip(self._turns, self._turns[1:], strict=False))
        self._left = dict.fromkeys(self._turns)  # in their order
        self._busy: set[Turn] = set()  # time alone brings them on
        self._windows: list[Window] = []
        self._errors: list[Step] = []
        self._timer: Timer | None = None
        self.horizon = self._lasts = self._begin = 0
        """`horizon`: the last microsecond of every window so far, decided or not."""

    def start(self) -> None:
        """It begins now; its first steps come with the next move of the clock."""
        self._begin = self.horizon = self._lasts = self._clock.ticks
        if self._duration:
            self.heals(self._begin + microseconds(self._duration))
        for turn in self._turns:
            if isinstance(turn.step.moment, At):
                tick = self._begin + microseconds(turn.step.moment.seconds)
                self._schedule(turn, tick)
                self.horizon = max(self.horizon, tick + microseconds(_takes(turn.step)))
        for turn in self._turns[:1]:
            self._prepare(turn, self._crew.senses.position)
            self._follow(turn, self._crew.senses.position)
        self._settle()

    @property
    def settled(self) -> bool:
        """Whether nothing is left to be done or decided."""
        return not self._left and not self._windows and self._clock.ticks >= self._lasts

    @property
    def undecided(self) -> Iterator[tuple[Step, Finding]]:
        """What would be said of what is left if the run ended now."""
        for window in self._windows:
            yield window.step, UNDECIDED
        for turn in self._left:
            if turn.begun:
                yield turn.step, UNDECIDED
        missed = [turn.step for turn in self._left if not turn.begun]
        if missed:
            text = f"{len(missed)} steps from here on were not reached"
            yield missed[0], Finding(Kind.ERROR, text)

    def expire(self) -> None:
        """Its time is over, whatever is left."""
        for window in list(self._windows):
            self._drop(window, UNDECIDED)
        for turn in list(self._left):
            if turn.begun or turn.scheduled:
                self._give_up(turn, UNDECIDED)
        self._end()

    # what turns and windows tell of themselves

    def begins(self, turn: Turn, since: Position) -> None:
        """The next one may watch from this position on."""
        now = self._clock.ticks
        self._busy.add(turn)
        self.horizon = max(self.horizon, now + microseconds(_takes(turn.step)))
        if (after := self._after.get(turn)) is not None:
            self._prepare(after, since)

    def ends(self, turn: Turn) -> None:
        """The next one may come."""
        self._busy.discard(turn)
        self._left.pop(turn, None)
        if (after := self._after.get(turn)) is not None:
            self._follow(after, turn.since)
        self._settle()

    def opens(self, window: Window) -> None:
        """It has to be decided."""
        self._windows.append(window)

    def decides(self, window: Window, finding: Finding, tick: int) -> None:
        """It is."""
        self._windows.remove(window)
        self._crew.judge.decide(window.step, finding, tick)
        self._settle()

    def heals(self, tick: int) -> None:
        """It is not over before that."""
        self._lasts = max(self._lasts, tick + GRAIN)

    def breaks(self, step: Step) -> None:
        """The rest is left out, from the next thing on that the clock does."""
        if self._strict and not self._errors:
            self._clock.at_tick(self._clock.ticks, self._end)
        self._errors.append(step)

    def _prepare(self, turn: Turn, since: Position) -> None:
        if isinstance(turn.step.moment, Condition) and not self._stopped:
            turn.watch(turn.step.moment, since)

    def _follow(self, turn: Turn, since: Position) -> None:
        if isinstance(turn.step.moment, After) and not self._stopped:
            self._schedule(turn, self._clock.ticks + microseconds(turn.step.moment.seconds), since)

    def _schedule(self, turn: Turn, tick: int, since: Position = WHOLE_MOMENT) -> None:
        self._busy.add(turn)
        turn.schedule(tick, since)

    @property
    def _stopped(self) -> bool:
        return self.over or (self._strict and bool(self._errors))

    # the end

    def _settle(self) -> None:
        """If only the end is left to wait for, wait for it."""
        bounded = any(window.last is not None for window in self._windows)
        if self.over or self._timer is not None or self._busy or bounded:
            return
        decided = not self._left and not self._windows
        last = self._clock.ticks if decided else self.horizon
        tick = max(last + GRAIN, self._lasts, self._clock.ticks)
        self._timer = self._clock.at_tick(tick, self._end_if_settled)

    def _end_if_settled(self) -> None:
        self._timer = None
        bounded = any(window.last is not None for window in self._windows)
        if self._busy or bounded or self._clock.ticks < self._lasts:
            self._settle()
        else:
            self._end()

    def _end(self) -> None:
        if self.over:
            return
        self.over = True
        if self._timer is not None:
            self._timer.cancel()
        self._close_windows()
        self._close_turns()
        self._tell_over()

    def _close_windows(self) -> None:
        for window in list(self._windows):
            if self._errors and self._strict:
                self._drop(window, self._left_out())
            else:
                window.close()

    def _close_turns(self) -> None:
        waiting = [] if self._errors else [turn for turn in self._left if turn.waiting]
        for turn in waiting:
            self._give_up(turn, NEVER_CAME)
        for turn in list(self._left):
            self._give_up(turn, self._left_out())
        for client in self._crew.clients.values():
            client.drop()

    def _drop(self, window: Window, finding: Finding) -> None:
        window.drop()
        self._windows.remove(window)
        self._crew.judge.decide(window.step, finding, self._clock.ticks)
        if finding.kind is Kind.ERROR:
            self._errors.append(window.step)

    def _give_up(self, turn: Turn, finding: Finding) -> None:
        turn.drop()
        self._left.pop(turn)
        if not turn.broken:
            self._crew.judge.decide(turn.step, finding, self._clock.ticks)
        if finding.kind is Kind.ERROR:
            self._errors.append(turn.step)

    def _left_out(self) -> Finding:
        return Finding(Kind.SKIP, f"left out after the error in line {self._errors[0].line}")


def _takes(step: Step) -> float:
    """Seconds from its first moment to the end of the last window it opens."""
    expects = step.action.seconds if isinstance(step.action, Expectation) else None
    return (step.times - 1) * step.every + (expects or 0.0)
