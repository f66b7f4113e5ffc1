"""Steps one after the other, each at its moment, and when they are over."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise

from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.scenario.actions import (
    Expectation,
)
from canopen_twins.scenario.bus_events import WHOLE_MOMENT, Position
from canopen_twins.scenario.expectation_run import GRAIN, ExpectationRun, Watch
from canopen_twins.scenario.matchers import Condition
from canopen_twins.scenario.scenario import After, At, Step
from canopen_twins.scenario.step_run import Resources, StepRun
from canopen_twins.scenario.verdict import Finding, Kind

UNDECIDED = Finding(Kind.ERROR, "the run ended before it was decided")
NEVER_CAME = Finding(Kind.ERROR, "its moment never came")
PATIENCE = 60.0  # seconds; as long as it takes to start a master by hand


class StepSequence:
    """Steps one after the other, each at its moment; it alone says when they are over.

    They are over when nothing is left, or nothing that time alone would bring on, though not before
    `duration` in seconds. What is left then are conditions that have not been met, and expectations
    that only the end closes. With None for `duration`, conditions are waited for another minute.
    With `strict`, the first error ends all at once. The end is told to `ended`.
    """

    def __init__(
        self,
        steps: Sequence[Step],
        resources: Resources,
        ended: Callable[[], None] = lambda: None,
        duration: float | None = 0.0,
        strict: bool = True,
    ) -> None:
        self.over = False
        self.horizon = 0
        """The last microsecond of all that is known to come, of windows even if decided."""
        self.never_came = NEVER_CAME
        """What is said of a condition that has not been met."""
        self._resources = resources
        self._bus = resources.bus
        self._clock = resources.bus.clock
        self._ended = ended
        self._duration = duration
        self._strict = strict
        runs = [StepRun(step, resources, self._follow_up) for step in steps]
        self._left = dict.fromkeys(runs)  # in their order
        self._next = dict(pairwise(runs))
        self._open: list[ExpectationRun] = []
        self._errors: list[Step] = []
        self._reason = ""  # why all the rest is left out, if it is not for an error of a step
        self._lasts = 0  # not over before this microsecond
        self._timer: Timer | None = None

    def start(self) -> None:
        """They begin now; the first ones come with the next move of the clock."""
        now, here = self._clock.ticks, self._bus.position
        self.horizon = self._lasts = now
        if self._duration:
            self._last_until(now + microseconds(self._duration))
        for run in self._left:
            if isinstance(run.step.moment, At):
                self._schedule(run, now + microseconds(run.step.moment.seconds), WHOLE_MOMENT)
        for first in [*self._left][:1]:
            self._watch_for(first, here)
            self._come_after(first, here)
        self._settle()

    @property
    def settled(self) -> bool:
        """Whether nothing is left to be done or decided, so that the end is near."""
        return not self._left and not self._open and self._clock.ticks >= self._lasts

    @property
    def undecided(self) -> Iterator[tuple[Step, Finding]]:
        """What would be said of what is left if the run ended now."""
        for expected in self._open:
            yield expected.step, UNDECIDED
        missed = [run.step for run in self._left if not run.rounds]
        yield from ((run.step, UNDECIDED) for run in self._left if run.rounds)
        if missed:
            yield missed[0], _not_reached(len(missed))

    def go_on_until(self, tick: int) -> None:
        """It is not over before the end of a microsecond, whoever says so."""
        if not self.over:
            self._last_until(tick)
            self._settle()

    # A step waits for its moment, is carried out, and lets the next one come

    def _schedule(self, run: StepRun, tick: int, since: Position) -> None:
        """What happens at the microsecond of its moment counts from a position on."""
        self._reach(tick + microseconds(_takes(run.step)))
        run.scheduled, run.since = True, since
        run.timer = self._clock.at_tick(tick, partial(self._carry_out, run))

    def _watch_for(self, run: StepRun, since: Position) -> None:
        if isinstance(run.step.moment, Condition) and not self._stopped:
            run.watch = Watch.of(run.step.moment, self._bus, partial(self._set_off, run))
            run.watch.listen(since)

    def _come_after(self, run: StepRun, since: Position) -> None:
        if isinstance(run.step.moment, After) and not self._stopped:
            self._schedule(run, self._clock.ticks + microseconds(run.step.moment.seconds), since)

    def _set_off(self, run: StepRun, told: str) -> None:
        here = self._bus.position
        self._schedule(run, self._clock.ticks, here)  # not in the middle of what happens
        self._begin(run, here)

    def _begin(self, run: StepRun, since: Position) -> None:
        """Its moment has come: the next one may watch from this position on."""
        self._reach(self._clock.ticks + microseconds(_takes(run.step)))
        if (after := self._next.get(run)) is not None:
            self._watch_for(after, since)

    def _carry_out(self, run: StepRun) -> None:
        if self._stopped:
            return
        if not run.rounds and run.watch is None:
            self._begin(run, self._bus.position)
        step, run.rounds = run.step, run.rounds + 1
        if run.rounds < step.times:
            tick = self._clock.ticks + microseconds(step.every)
            run.timer = self._clock.at_tick(tick, partial(self._carry_out, run))
        self._resources.log.tell(step.node, "step", line=step.line, what=str(step.action))
        if isinstance(step.action, Expectation):
            expected = ExpectationRun(step, step.action, self._bus, self._decide)
            self._open.append(expected)
            expected.open(run.since)
        else:
            run.act()
        self._follow_up(run)

    def _follow_up(self, run: StepRun) -> None:
        """Strictly, what comes after an error is left out, from the clock's next thing on."""
        if run.failed:
            if self._strict and not self._errors:
                self._clock.at_tick(self._clock.ticks, self._end)
            self._errors.append(run.step)
        if run.lasts:
            self._last_until(run.lasts)
        if run.done and run in self._left:
            del self._left[run]
            if (after := self._next.get(run)) is not None:
                self._come_after(after, run.since)
            self._settle()

    def _decide(self, expected: ExpectationRun, finding: Finding, tick: int) -> None:
        self._open.remove(expected)
        self._resources.log.decide(expected.step, finding, tick)
        self._settle()

    # When it is over

    @property
    def failed(self) -> bool:
        """Whether an error has ended it all."""
        return bool(self._reason) or (self._strict and bool(self._errors))

    @property
    def _stopped(self) -> bool:
        """Whether nothing is carried out any more."""
        return self.over or self.failed

    def _reach(self, tick: int) -> None:
        """Something may still come then."""
        self.horizon = max(self.horizon, tick)

    def _last_until(self, tick: int) -> None:
        """It is not over before the end of a microsecond."""
        self._lasts = max(self._lasts, tick + GRAIN)
        self._reach(tick)

    def _settle(self) -> None:
        """If only the end is left to wait for, wait for it."""
        if self._timer is not None:
            self._timer.cancel()
        if not self._moves:
            self._timer = self._clock.at_tick(max(self._due, self._clock.ticks), self._look)

    def _look(self) -> None:
        self._timer = None
        if not self._moves:
            self._end()

    @property
    def _moves(self) -> bool:
        """Whether time alone brings something on."""
        return any(run.scheduled for run in self._left) or any(
            expected.last is not None for expected in self._open
        )

    @property
    def _due(self) -> int:
        """The microsecond of the end, if nothing comes in between."""
        last = self.horizon if self._left or self._open else self._clock.ticks
        waits = any(run.waiting for run in self._left) or any(each.waits for each in self._open)
        patience = microseconds(PATIENCE) if waits and self._duration is None else 0
        return max(last + GRAIN + patience, self._lasts)

    def expire(self) -> None:
        """The time for them is over, whatever is left."""
        for expected in [*self._open]:
            self._drop(expected, UNDECIDED)
        self.conclude()

    def conclude(self) -> None:
        """The run ends here: what waits for its end is decided, what waits for time is not."""
        for expected in [each for each in self._open if each.last is not None]:
            self._drop(expected, UNDECIDED)
        for run in [run for run in self._left if run.rounds]:
            self._give_up(run, UNDECIDED)
        missed = [run for run in self._left if run.scheduled]
        if missed:
            self._give_up(missed[0], _not_reached(len(missed)))
        self._end()

    def abort(self, reason: str) -> None:
        """The run ends here, and nothing that is left says anything."""
        if not self.over:
            self._reason = f"left out: {reason}"
            self._end()

    def _end(self) -> None:
        if self.over:
            return
        self.over = True
        if self.failed:
            self.horizon = self._clock.ticks
        for expected in [*self._open]:
            if self.failed:
                self._drop(expected, self._left_out)
            else:
                expected.close()
        for run in [run for run in self._left if run.waiting and not self._left_out_for]:
            self._give_up(run, self.never_came)
        for run in [*self._left]:
            self._give_up(run, self._left_out)
        self._resources.master.drop()
        self._ended()

    def _drop(self, expected: ExpectationRun, finding: Finding) -> None:
        expected.drop()
        self._open.remove(expected)
        self._conclude(expected.step, finding)

    def _give_up(self, run: StepRun, finding: Finding) -> None:
        run.drop()
        del self._left[run]
        if not run.failed:
            self._conclude(run.step, finding)

    def _conclude(self, step: Step, finding: Finding) -> None:
        self._resources.log.decide(step, finding)
        if finding.kind is Kind.ERROR:
            self._errors.append(step)

    @property
    def _left_out_for(self) -> str:
        """Why what is left is left out, in words; empty if it is not."""
        if self._reason or not self._errors:
            return self._reason
        return f"left out after the error in line {self._errors[0].line}"

    @property
    def _left_out(self) -> Finding:
        if not self._left_out_for:  # what it stands behind never came, which was no error
            return self.never_came
        return Finding(Kind.SKIP, self._left_out_for)


def _not_reached(count: int) -> Finding:
    steps = "1 step from here on was" if count == 1 else f"{count} steps from here on were"
    return Finding(Kind.ERROR, f"{steps} not reached")


def _takes(step: Step) -> float:
    """Seconds from its first moment to the end of the last window it opens."""
    expects = step.action.seconds if isinstance(step.action, Expectation) else None
    return (step.times - 1) * step.every + (expects or 0.0)
