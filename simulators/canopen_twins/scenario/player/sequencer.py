"""Steps one after the other, each at its moment, until the last expectation is decided."""

from collections.abc import Callable, Sequence

from canopen_twins.bus.clock import microseconds
from canopen_twins.scenario.expect import Expectation
from canopen_twins.scenario.player.agenda import UNDECIDED, Agenda
from canopen_twins.scenario.player.happenings import Position
from canopen_twins.scenario.player.tools import Tools
from canopen_twins.scenario.player.turn import WHOLE_MOMENT, Turn
from canopen_twins.scenario.player.window import Window
from canopen_twins.scenario.scenario import After, At, Condition, Step
from canopen_twins.scenario.verdict import Finding, Kind

NEVER_CAME = Finding(Kind.ERROR, "its moment never came")


class Sequencer:
    """Calls `tell_over` once it is over, which is not before `duration` in seconds.

    With None for it, conditions have as long as a master may need that is started by hand.
    With `strict`, the first error ends it at once.
    """

    def __init__(
        self,
        steps: Sequence[Step],
        tools: Tools,
        tell_over: Callable[[], None] = lambda: None,
        duration: float | None = 0.0,
        strict: bool = True,
    ) -> None:
        self.over = False
        self._tools = tools
        self._clock = tools.clock
        self._tell_over = tell_over
        self._duration = duration
        self._strict = strict
        self._turns = [Turn(step, tools, self) for step in steps]
        self._after = dict(zip(self._turns, self._turns[1:], strict=False))
        self._errors: list[Step] = []
        self.agenda = Agenda(self._turns, tools.clock, self._end)

    def start(self) -> None:
        """It begins now; its first steps come with the next move of the clock."""
        self.agenda.begin(self._duration)
        for turn in self._turns:
            if isinstance(turn.step.moment, At):
                self._schedule(turn, self._clock.ticks + microseconds(turn.step.moment.seconds))
        for turn in self._turns[:1]:
            self._prepare(turn, self._tools.happenings.position)
            self._follow(turn, self._tools.happenings.position)
        self.agenda.settle()

    def expire(self) -> None:
        """Its time is over, whatever is left."""
        for window in list(self.agenda.windows):
            self._drop(window, UNDECIDED)
        for turn in list(self.agenda.turns):
            if turn.begun or turn.scheduled:
                self._give_up(turn, UNDECIDED)
        self._end()

    # what turns and windows ask and tell

    @property
    def stopped(self) -> bool:
        """Whether nothing is carried out any more."""
        return self.over or self._failed

    @property
    def _failed(self) -> bool:
        return self._strict and bool(self._errors)

    def begins(self, turn: Turn, since: Position) -> None:
        """The next one may watch from this position on."""
        self.agenda.expect(turn)
        self.agenda.reach(self._clock.ticks + microseconds(_takes(turn.step)))
        if (after := self._after.get(turn)) is not None:
            self._prepare(after, since)

    def ends(self, turn: Turn) -> None:
        """The next one may come."""
        self.agenda.cross_off(turn)
        if (after := self._after.get(turn)) is not None:
            self._follow(after, turn.since)
        self.agenda.settle()

    def opens(self, window: Window) -> None:
        """It has to be decided."""
        self.agenda.windows.append(window)

    def decides(self, window: Window, finding: Finding, tick: int) -> None:
        """It is."""
        self.agenda.windows.remove(window)
        self._tools.judge.decide(window.step, finding, tick)
        self.agenda.settle()

    def heals(self, tick: int) -> None:
        """It is not over before that."""
        self.agenda.last_until(tick)

    def breaks(self, step: Step) -> None:
        """The rest is left out, from the next thing on that the clock does."""
        if self._strict and not self._errors:
            self._clock.at_tick(self._clock.ticks, self._end)
        self._errors.append(step)

    def _prepare(self, turn: Turn, since: Position) -> None:
        if isinstance(turn.step.moment, Condition) and not self.stopped:
            turn.watch(turn.step.moment, since)

    def _follow(self, turn: Turn, since: Position) -> None:
        if isinstance(turn.step.moment, After) and not self.stopped:
            self._schedule(turn, self._clock.ticks + microseconds(turn.step.moment.seconds), since)

    def _schedule(self, turn: Turn, tick: int, since: Position = WHOLE_MOMENT) -> None:
        self.agenda.expect(turn)
        self.agenda.reach(tick + microseconds(_takes(turn.step)))
        turn.schedule(tick, since)

    # the end

    def _end(self) -> None:
        if not self.over:
            self.over = True
            if self._failed:
                self.agenda.horizon = self._clock.ticks
            self._close_windows()
            self._close_turns()
            self._tell_over()

    def _close_windows(self) -> None:
        for window in list(self.agenda.windows):
            if self._failed:
                self._drop(window, self._left_out())
            else:
                window.close()

    def _close_turns(self) -> None:
        waiting = [] if self._errors else [turn for turn in self.agenda.turns if turn.waiting]
        for turn in waiting:
            self._give_up(turn, NEVER_CAME)
        for turn in list(self.agenda.turns):
            self._give_up(turn, self._left_out())
        for client in self._tools.clients.values():
            client.drop()

    def _drop(self, window: Window, finding: Finding) -> None:
        window.drop()
        self.agenda.windows.remove(window)
        self._decide(window.step, finding)

    def _give_up(self, turn: Turn, finding: Finding) -> None:
        turn.drop()
        self.agenda.cross_off(turn)
        if not turn.broken:
            self._decide(turn.step, finding)

    def _decide(self, step: Step, finding: Finding) -> None:
        self._tools.judge.decide(step, finding, self._clock.ticks)
        if finding.kind is Kind.ERROR:
            self._errors.append(step)

    def _left_out(self) -> Finding:
        return Finding(Kind.SKIP, f"left out after the error in line {self._errors[0].line}")


def _takes(step: Step) -> float:
    """Seconds from its first moment to the end of the last window it opens."""
    expects = step.action.seconds if isinstance(step.action, Expectation) else None
    return (step.times - 1) * step.every + (expects or 0.0)
