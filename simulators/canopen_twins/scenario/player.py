"""A scenario on a segment, whoever drives its clock: its steps in their order, then its cleanup."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from canopen_twins.bench.python_master import Ended
from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.scenario.actions import (
    Expectation,
    Inject,
    Limit,
    Nmt,
    RunMaster,
    Surroundings,
    Write,
)
from canopen_twins.scenario.always import Rule
from canopen_twins.scenario.bus_events import BusEvents
from canopen_twins.scenario.disturbances import Disturbances, Healing
from canopen_twins.scenario.expectation_run import GRAIN
from canopen_twins.scenario.matchers import Condition, Entered, Matcher, Written
from canopen_twins.scenario.run_log import RunLog
from canopen_twins.scenario.scenario import At, Scenario, Step
from canopen_twins.scenario.sdo_client import ScenarioMaster
from canopen_twins.scenario.step_run import InjectedFaults, Resources
from canopen_twins.scenario.step_sequence import StepSequence
from canopen_twins.scenario.verdict import Finding, Kind, Outcome, Verdict
from canopen_twins.slave.service import State

WITHOUT_MASTER = Finding(Kind.SKIP, "left out: the master has ended before")
REAL = Finding(Kind.SKIP, "left out: this bus is not simulated, and has a bit rate of its own")
LEFT_BEHIND = "has left processes behind, which were ended"
DECIDES_ITSELF = Finding(Kind.SKIP, "left out: this bus is not simulated, and decides itself")
NAME = "scenario"
LONGEST = 86_400  # seconds of a run


class Player:
    """Puts every step on the clock; `nodes` are those of the scenario, by its names.

    Started before their power is switched on, it hears them boot. `listeners` hear what it does.
    With `until_told` it is not over before `conclude`, as where a command ends the run.

    Raises:
        UserError: a node of the scenario is missing.
    """

    def __init__(
        self,
        scenario: Scenario,
        segment: Segment[Node],
        nodes: Mapping[str, Node],
        until_told: bool = False,
    ) -> None:
        for name in scenario.nodes:
            if name not in nodes:
                raise UserError(f"{scenario.file} is about a {name}; here is {', '.join(nodes)}")
        self.scenario = scenario
        self.ended: Ended | None = None
        """How the master of the file has ended, if otherwise than by returning."""
        self.whereabouts: Callable[[], str] = lambda: ""
        """Tells in which lines of its files the master is; empty if nobody knows."""
        self.no_master_heard = False
        """Whether nobody outside has sent anything for so long that it explains what is missed."""
        self._segment = segment
        self._clock = segment.clock
        self._nodes = {name: nodes[name] for name in scenario.nodes}
        self._master = ScenarioMaster(segment, self._nodes, NAME)
        self._bus = BusEvents(self._nodes, segment.clock)
        self._log = RunLog(self._nodes, segment.clock)
        self.listeners = self._log.listeners
        self._listening: dict[str, Callable[[State], None]] = {}
        faults = InjectedFaults(self._nodes, self._log)
        shared = Resources(self._bus, self._master, faults, self._log)
        duration = LONGEST if until_told else scenario.length
        self._steps = StepSequence(scenario.steps, shared, self._end, duration)
        self._disturbances = Disturbances(scenario.disturbances, shared)
        self._healing = Healing(scenario, self._disturbances, self._steps, shared, self._end)
        self._always = [Rule(each, shared) for each in scenario.always]
        self._cleanup = StepSequence(scenario.cleanup, shared, strict=False)

    def start(self) -> None:
        """The scenario begins now; its first steps come with the next move of the clock."""
        self._log.begin()
        self._segment.listeners.append(self._hear)
        for name, node in self._nodes.items():
            self._listening[name] = partial(self._tell_state, name)
            node.listeners.append(self._listening[name])
        for name, matcher in _watched(self.scenario):
            if isinstance(matcher, Entered):
                self._bus.follow_states(name)
            elif isinstance(matcher, Written):
                self._bus.follow_writes(name)
        limit = self._clock.ticks + microseconds(LONGEST) + GRAIN
        self._limit = self._clock.at_tick(limit, self.stop)
        self._leave_out_what_is_simulated()
        self._disturbances.start()
        for rule in self._always:
            rule.start()
        self._healing.start()
        self._steps.start()

    def stop(self) -> None:
        """End it before its time: what is left is an ERROR, and the cleanup begins."""
        self._steps.expire()
        self._healing.expire()

    def leave(self) -> None:
        """It is over, while the bus goes on: hear no more."""
        self._segment.listeners.remove(self._hear)
        for name, listener in self._listening.items():
            self._nodes[name].listeners.remove(listener)
        self._bus.leave()

    @property
    def done(self) -> bool:
        """Whether every step has been carried out and every expectation decided."""
        steps_over = self._steps.over or (self._steps.settled and not self.scenario.cleanup)
        return steps_over and self._healing.over and self._cleanup.settled

    def conclude(self) -> None:
        """End the steps at this moment; what is left is their cleanup."""
        self._steps.conclude()
        self._healing.expire()

    def blame(self, what: str, seen: str) -> None:
        """Something around the run, and no step of it, is in error."""
        step = Step(At(0), "", Surroundings(what), "", 0)
        self._log.decide(step, Finding(Kind.ERROR, seen))

    def abort(self, what: str, seen: str) -> None:
        """The same, and the run says nothing from here on; what is left is its cleanup."""
        self.blame(what, seen)
        self._steps.abort(f"{what} {seen}")
        self._healing.expire()

    @property
    def horizon(self) -> float:
        """Time of the clock before which the run is not over, unless an error ends it."""
        parts = (self._steps, self._healing, self._cleanup)
        return (max(part.horizon for part in parts) + GRAIN) / MICROSECONDS

    @property
    def fired(self) -> Sequence[Step]:
        """The disturbances whose moment has come."""
        return self._disturbances.fired

    @property
    def is_about_a_master(self) -> bool:
        """Whether something is waited for or expected that a master does, and none of its steps."""
        own = (step.action for step in self.scenario.steps)
        driven = any(isinstance(action, (Write, Nmt)) for action in own)
        return not driven and any(matcher.by_master for _, matcher in _watched(self.scenario))

    @property
    def judged(self) -> bool:
        """Whether anything has been decided by now."""
        return self.done or self._log.judged

    @property
    def verdict(self) -> Verdict:
        """What has been found; what is not decided by now counts as an error."""
        outcomes = self._log.outcomes(
            [*self._steps.undecided, *self._healing.undecided, *self._cleanup.undecided]
        )
        if self.no_master_heard:
            outcomes = tuple(map(_without_master, outcomes))
        told, now = self.scenario, self._log.now
        return Verdict(str(told.file), outcomes, told.name, told.seed, seconds=now)

    def tell_of_master(self, ended: Ended) -> None:
        """The master of the file has ended otherwise than by returning."""
        scenario = self.scenario
        assert scenario.master is not None
        self.ended = ended
        kind = Kind.FAIL if ended.its_own else Kind.ERROR
        step = Step(At(0), "", RunMaster(scenario.master.name), "", scenario.master_line)
        self._log.decide(step, Finding(kind, ended.words))
        self._steps.never_came = WITHOUT_MASTER

    def tell_of_processes(self, told: str) -> None:
        """The master of the file has left processes behind, which have been ended."""
        scenario = self.scenario
        assert scenario.master is not None
        step = Step(At(0), "", RunMaster(scenario.master.name), "", scenario.master_line)
        self._log.decide(step, Finding(Kind.SKIP, f"{LEFT_BEHIND}: {told}"))

    def _hear(self, frame: Frame, sender: str) -> None:
        self._log.hear(frame, sender)
        self._master.hear(frame)
        self._bus.hear(frame, sender)

    def _tell_state(self, name: str, state: State) -> None:
        self._log.tell(name, "state", state=str(state))

    def _leave_out_what_is_simulated(self) -> None:
        """What only a simulated bus can do is no part of a verdict on another one."""
        scenario = self.scenario
        if scenario.bit_rate is not None and not self._segment.limited:
            step = Step(At(0), "", Limit(scenario.bit_rate), "", scenario.bit_rate_line)
            self._log.decide(step, REAL)
        if scenario.arbitration is not None and self._segment.first is None:
            step = Step(At(0), "", Surroundings("arbitration"), "", scenario.arbitration_line)
            self._log.decide(step, DECIDES_ITSELF)

    def _end(self) -> None:
        """The cleanup comes when both are over; nobody is back from steps that say nothing."""
        if self._steps.over and self._steps.failed:
            self._healing.drop()
        if self._steps.over and self._healing.over:
            self._limit.cancel()
            for rule in self._always:
                rule.end()
            self._cleanup.start()


def _without_master(outcome: Outcome) -> Outcome:
    """What did not come, with the reason that stands behind all of it."""
    if outcome.kind not in (Kind.FAIL, Kind.ERROR) or not outcome.line:
        return outcome
    return replace(outcome, seen=f"no master heard ({outcome.seen})")


def _watched(scenario: Scenario) -> Iterator[tuple[str, Matcher]]:
    """The names of nodes, and what is ever watched for there."""
    if (back := scenario.recovers) is not None:
        yield back.condition.node, back.condition.matcher
    for step in (
        *scenario.steps,
        *scenario.disturbances,
        *(each.step for each in scenario.always),
        *scenario.cleanup,
    ):
        action, conditions = step.action, [step.moment]
        if isinstance(action, Expectation):
            yield step.node, action.matcher
            conditions += [action.before] if action.before else []
        elif isinstance(action, Inject) and isinstance(action.lasts, Condition):
            conditions.append(action.lasts)
        for condition in conditions:
            if isinstance(condition, Condition):
                yield condition.node, condition.matcher
