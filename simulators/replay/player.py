"""Plays a scenario on a segment, whoever drives its clock: simulated time or real time."""

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from simulators.clock import MICROSECONDS, microseconds
from simulators.errors import UserError
from simulators.node import Node
from simulators.replay.master import Master
from simulators.replay.scenario import Expectation, Scenario, Stage, Step
from simulators.replay.verdict import Finding, Kind, Outcome, Verdict
from simulators.replay.window import Window
from simulators.report import SHOWN, device_story, last_frames
from simulators.segment import Record, Segment
from simulators.wire import Frame


class Player:
    """Puts every step on the clock; `nodes` are those of the scenario, by its names.

    Started before their power is switched on, it hears them boot.

    Raises:
        UserError: a node of the scenario is missing.
    """

    def __init__(self, scenario: Scenario, segment: Segment, nodes: Mapping[str, Node]) -> None:
        for name in scenario.nodes:
            if name not in nodes:
                raise UserError(f"{scenario.file} is about a {name}; here is {', '.join(nodes)}")
        self.scenario = scenario
        self._segment = segment
        self._clock = segment.clock
        self._nodes = nodes
        self._master = Master(segment)
        self._begin = self._clock.ticks
        self._left = deque(scenario.steps)
        self._windows: list[Window] = []
        self._outcomes: list[Outcome] = []
        self._recent: deque[Record] = deque(maxlen=SHOWN)
        self._moment = self._begin
        self._heard: list[tuple[Frame, str]] = []  # at this moment

    def start(self) -> None:
        """The scenario begins now; its first steps come with the next move of the clock."""
        self._begin = self._moment = self._clock.ticks
        self._segment.listeners.append(self._hear)
        for step in self.scenario.steps:
            self._clock.at_tick(self._begin + microseconds(step.at), partial(self._play, step))

    @property
    def done(self) -> bool:
        """Whether every step has been carried out and every expectation decided."""
        return not self._left and not self._windows

    @property
    def verdict(self) -> Verdict:
        """What has been found; what is not decided by now counts as an error."""
        outcomes = [*self._outcomes]
        for window in self._windows:
            outcomes.append(self._outcome(window.step, UNDECIDED, self._clock.ticks))
        if self._left:
            finding = Finding(Kind.ERROR, f"{len(self._left)} steps from here on were not reached")
            outcomes.append(self._outcome(self._left[0], finding, self._clock.ticks))
        outcomes.sort(key=lambda outcome: outcome.line)
        return Verdict(str(self.scenario.file), tuple(outcomes))

    def _play(self, step: Step) -> None:
        self._left.popleft()
        stage = Stage(
            self._nodes[step.node],
            self._master,
            report=partial(self._report, step),
            watch=partial(self._watch, step),
        )
        try:
            step.action.carry_out(stage)
        except UserError as refusal:
            self._report(step, Finding(Kind.ERROR, str(refusal)))

    def _watch(self, step: Step, expectation: Expectation) -> None:
        window = Window(step, expectation, self._nodes[step.node], self._clock, self._decide)
        self._windows.append(window)
        if self._moment == self._clock.ticks:
            for frame, sender in self._heard:
                self._tell(window, frame, sender)

    def _hear(self, frame: Frame, sender: str) -> None:
        if self._moment != self._clock.ticks:
            self._moment = self._clock.ticks
            self._heard.clear()
        self._heard.append((frame, sender))
        self._recent.append(Record(self._time(self._clock.ticks), frame, sender))
        for window in tuple(self._windows):
            self._tell(window, frame, sender)

    def _tell(self, window: Window, frame: Frame, sender: str) -> None:
        if window in self._windows and sender == window.node.wire.name:
            window.hear(frame)

    def _decide(self, window: Window, finding: Finding, tick: int) -> None:
        self._windows.remove(window)
        self._outcomes.append(self._outcome(window.step, finding, tick))

    def _report(self, step: Step, finding: Finding) -> None:
        self._outcomes.append(self._outcome(step, finding, self._clock.ticks))

    def _outcome(self, step: Step, finding: Finding, tick: int) -> Outcome:
        time, what = self._time(tick), str(step.action)
        outcome = Outcome(finding.kind, time, step.line, what, finding.seen, step.note)
        if finding.kind is Kind.PASS:
            return outcome
        recent, node = tuple(self._recent), self._nodes[step.node]
        frames = last_frames(recent, tuple(self._nodes.values()))
        story = device_story(node, recent, self._begin / MICROSECONDS, what)
        return replace(outcome, scene=f"{frames}\n{story}")

    def _time(self, tick: int) -> float:
        return (tick - self._begin) / MICROSECONDS


UNDECIDED = Finding(Kind.ERROR, "the run ended before it was decided")
