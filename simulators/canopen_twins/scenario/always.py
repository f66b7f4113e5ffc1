"""What is expected every time that something is seen, beside the steps and as long as they last."""

from canopen_twins.bus.clock import microseconds
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.bus_events import Position
from canopen_twins.scenario.expectation_run import ExpectationRun, Watch
from canopen_twins.scenario.scenario import Step, Whenever
from canopen_twins.scenario.step_run import Resources
from canopen_twins.scenario.verdict import Finding, Kind


class Rule:
    """An expectation that begins whenever its condition is seen, but not twice at a time.

    One that begins later, and is over by then, does not begin.

    The first time that it fails is told at once, and is the last. What is still open in the end is
    not judged; if it has always passed, that is told then, with how often.
    """

    def __init__(self, whenever: Whenever, resources: Resources) -> None:
        self._whenever = whenever
        self._step: Step = whenever.step
        self._bus = resources.bus
        self._log = resources.log
        self._watch: Watch | None = None
        self._ends: list[Watch] = []
        """What watches for the ends of those that have yet to begin."""
        self._run: ExpectationRun | None = None
        self._passed = 0

    def start(self) -> None:
        """It is watched for from now on."""
        self._watch = Watch.of(self._whenever.condition, self._bus, self._set_off)
        self._watch.again = True
        self._watch.listen(self._bus.position)

    def end(self) -> None:
        """Nothing is expected any more."""
        self._stop()
        if self._passed:
            told = f"{self._passed} times" if self._passed > 1 else "once"
            self._log.decide(self._step, Finding(Kind.PASS, told))

    def _stop(self) -> None:
        if self._watch is not None:
            self._watch.stop()
        for end in self._ends:
            end.stop()
        if self._run is not None:
            self._run.drop()

    def _set_off(self, told: str) -> None:
        clock, here = self._bus.clock, self._bus.position
        end = self._end_before(here)
        begin = clock.ticks + microseconds(self._whenever.seconds)
        clock.at_tick(begin, lambda: self._begin(here, end))  # not in the middle of what happens

    def _end_before(self, here: Position) -> Watch | None:
        """What watches for the end of an expectation until that begins."""
        before = self._expectation.before
        if not self._whenever.seconds or before is None:
            return None
        end = Watch.of(before, self._bus, lambda told: None)
        end.listen(here)
        self._ends.append(end)
        return end

    def _begin(self, since: Position, end: Watch | None) -> None:
        is_over = end is not None and not end.active
        if end is not None:
            end.stop()
            self._ends.remove(end)
        if self._run is None and self._watch is not None and self._watch.active and not is_over:
            self._run = ExpectationRun(self._step, self._expectation, self._bus, self._decide)
            self._run.open(since)

    @property
    def _expectation(self) -> Expectation:
        assert isinstance(self._step.action, Expectation)
        return self._step.action

    def _decide(self, run: ExpectationRun, finding: Finding, tick: int) -> None:
        self._run = None
        if finding.kind is Kind.PASS:
            self._passed += 1
        else:
            self._passed = 0
            self._stop()
            self._log.decide(self._step, finding, tick)
