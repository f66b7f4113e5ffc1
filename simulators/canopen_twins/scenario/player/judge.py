"""Takes down what is found, with the scene of what did not pass."""

from collections.abc import Callable, Iterable
from dataclasses import replace

from canopen_twins.scenario.player.scenes import Scene, Scenes
from canopen_twins.scenario.scenario import Step
from canopen_twins.scenario.verdict import Finding, Kind, Outcome

WITHOUT_SCENE = (Kind.PASS, Kind.SKIP)


class Judge:
    """Its outcomes are those so far, in the order of the file; `tell` hears of each with its step.

    `time` gives the seconds of the scenario for a microsecond of the clock.
    """

    def __init__(
        self,
        scenes: Scenes,
        time: Callable[[int], float],
        tell: Callable[[Step, Outcome], None],
    ) -> None:
        self._scenes = scenes
        self._time = time
        self._tell = tell
        self._decided: list[tuple[Outcome, Scene | None]] = []

    def decide(self, step: Step, finding: Finding, tick: int) -> None:
        """Take a finding down."""
        outcome = self._outcome(step, finding, tick)
        scene = None
        if finding.kind not in WITHOUT_SCENE:
            scene = self._scenes.begin(outcome.time, step)
        self._decided.append((outcome, scene))
        self._tell(step, outcome)

    def outcomes(self, undecided: Iterable[tuple[Step, Finding]], tick: int) -> tuple[Outcome, ...]:
        """All that has been decided, and what is to be said of the rest at this moment."""
        outcomes = [replace(each, scene=str(scene or "")) for each, scene in self._decided]
        for step, finding in undecided:
            outcome = self._outcome(step, finding, tick)
            scene = self._scenes.look(outcome.time, step)
            outcomes.append(replace(outcome, scene=str(scene)))
        return tuple(sorted(outcomes, key=lambda outcome: outcome.line))

    def _outcome(self, step: Step, finding: Finding, tick: int) -> Outcome:
        what = str(step.action)
        return Outcome(finding.kind, self._time(tick), step.line, what, finding.seen, step.note)
