"""What goes wrong beside the steps, and whether the master is back in time when all has healed."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.device.node import Node
from canopen_twins.scenario.actions import Expectation, Inject, Power, Set
from canopen_twins.scenario.expectation_run import Watch
from canopen_twins.scenario.matchers import Condition
from canopen_twins.scenario.scenario import After, At, Recovery, Scenario, Step
from canopen_twins.scenario.step_run import Resources, StepRun
from canopen_twins.scenario.step_sequence import StepSequence
from canopen_twins.scenario.verdict import Finding


class Disturbances:
    """Each waits for its own moment, from the beginning on, and does not mind the others.

    `fired` are those whose moment has come; nobody waits for the others.
    """

    def __init__(self, steps: Sequence[Step], resources: Resources) -> None:
        self.fired: list[Step] = []
        self._steps = steps
        self._resources = resources
        self._bus = resources.bus
        self._watches: list[Watch] = []
        self._timers: list[Timer] = []
        self._before: dict[str, dict[str, Any]] = {}  # what was set, by nodes

    def start(self) -> None:
        """They are watched for from now on."""
        now, here = self._bus.clock.ticks, self._bus.position
        for step in self._steps:
            if isinstance(step.moment, Condition):
                watch = Watch.of(step.moment, self._bus, partial(self._set_off, step))
                self._watches.append(watch)
                watch.listen(here)
            elif isinstance(step.moment, At):
                self._schedule(step, now + microseconds(step.moment.seconds))

    def _set_off(self, step: Step, told: str) -> None:
        self._schedule(step, self._bus.clock.ticks)  # not in the middle of what happens

    def _schedule(self, step: Step, tick: int) -> None:
        self._timers.append(self._bus.clock.at_tick(tick, partial(self._carry_out, step)))

    def _carry_out(self, step: Step) -> None:
        self.fired.append(step)
        self._resources.log.tell(step.node, "step", line=step.line, what=str(step.action))
        if isinstance(step.action, Set):
            self._remember(self._bus.nodes[step.node], step.node, step.action.settings)
        StepRun(step, self._resources, lambda run: None).act()

    def _remember(self, node: Node, name: str, settings: Mapping[str, Any]) -> None:
        before = self._before.setdefault(name, {})
        for key in settings:
            if node.device.knows(key):
                before.setdefault(key, node.device.current(key))

    def heal(self) -> None:
        """Nothing goes wrong any more: faults are cleared, what was set is as before, power is on.

        What the steps of the file do stays.
        """
        for watch in self._watches:
            watch.stop()
        for timer in self._timers:
            timer.cancel()
        for step in self.fired:
            if isinstance(step.action, Inject):
                for fault in step.action.faults:
                    self._resources.faults.clear(step.node, fault)
        for name, settings in self._before.items():
            with self._bus.nodes[name].acting() as device:
                device.set_back(**settings)
        for step in self.fired:
            if isinstance(step.action, Power):
                self._bus.nodes[step.node].power_on()


@dataclass(frozen=True)
class Back(Expectation):
    """Something that has to be so again; what is looked at, at the end of the time."""

    in_all: float = 0.0
    """Seconds."""

    def __str__(self) -> str:
        return f"back within {self.in_all:g} s: {self.matcher}"


class Healing:
    """At the end of `duration` all disturbances heal, and the master has to be back in time."""

    def __init__(
        self,
        scenario: Scenario,
        disturbances: Disturbances,
        steps: StepSequence,
        resources: Resources,
        ended: Callable[[], None],
    ) -> None:
        self._recovery = scenario.recovers
        self._after = scenario.duration or 0.0
        self._disturbances = disturbances
        self._steps = steps  # which judge until the end
        self._resources = resources
        self._ended = ended
        self._sequence = StepSequence([], resources)
        self._timer: Timer | None = None
        self.over = self._recovery is None
        self.horizon = 0
        """The last microsecond of all that is known to come."""

    def start(self) -> None:
        """The time in which things go wrong begins now."""
        if self._recovery is not None:
            clock = self._resources.bus.clock
            end = clock.ticks + microseconds(self._after)
            self._timer = clock.at_tick(end, self._heal)
            self.horizon = end + microseconds(self._recovery.seconds)

    def expire(self) -> None:
        """The time for it is over, whatever is left."""
        if not self.over:
            self._sequence.expire()
            self.drop()
            self._ended()

    def drop(self) -> None:
        """It does not matter any more."""
        if self._timer is not None:
            self._timer.cancel()
        self.over = True

    def _heal(self) -> None:
        assert self._recovery is not None
        self._disturbances.heal()
        step = _back(self._recovery, self._resources.bus.nodes)
        self._sequence = StepSequence([step], self._resources, self._end)
        self._sequence.start()
        self.horizon = max(self.horizon, self._sequence.horizon)
        self._steps.go_on_until(self.horizon)

    def _end(self) -> None:
        self.over = True
        self._ended()

    @property
    def undecided(self) -> Iterator[tuple[Step, Finding]]:
        """What would be said of what is left if the run ended now."""
        return self._sequence.undecided


def _back(recovery: Recovery, nodes: Mapping[str, Node]) -> Step:
    """What is expected when everything has healed: now."""
    matcher, seconds = recovery.condition.matcher, recovery.seconds
    boot = max((node.device.timing.boot_time for node in nodes.values() if node.booting), default=0)
    wait, within = (boot + seconds, None) if matcher.polled else (boot, seconds)
    back = Back(matcher, within, in_all=seconds)
    return Step(After(wait), recovery.condition.node, back, "", recovery.line)
