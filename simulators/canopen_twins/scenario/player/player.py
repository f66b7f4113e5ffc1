"""The player: it hears the bus, and lets the steps come and then the cleanup."""

from collections.abc import Callable, Mapping
from functools import partial

from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.scenario.actions import Limit
from canopen_twins.scenario.matchers import Entered, Written
from canopen_twins.scenario.player.client import Client
from canopen_twins.scenario.player.events import Event
from canopen_twins.scenario.player.happenings import Happenings
from canopen_twins.scenario.player.healing import Healing
from canopen_twins.scenario.player.judge import Judge
from canopen_twins.scenario.player.needs import needs
from canopen_twins.scenario.player.scenes import Scenes
from canopen_twins.scenario.player.sequencer import Sequencer
from canopen_twins.scenario.player.tools import Tools
from canopen_twins.scenario.player.watch import GRAIN
from canopen_twins.scenario.scenario import At, Scenario, Step
from canopen_twins.scenario.verdict import Finding, Kind, Outcome, Verdict
from canopen_twins.slave.service import State

NAME = "scenario"
LONGEST = 86_400  # seconds of a run
ANSWERS = range(0x581, 0x600)  # of SDO servers
REAL = Finding(Kind.SKIP, "left out: this bus is not simulated, and has a bit rate of its own")


class Player:
    """Puts every step on the clock; `nodes` are those of the scenario, by its names.

    Started before their power is switched on, it hears them boot. `listeners` hear what it does.

    Raises:
        UserError: a node of the scenario is missing.
    """

    def __init__(
        self, scenario: Scenario, segment: Segment[Node], nodes: Mapping[str, Node]
    ) -> None:
        for name in scenario.nodes:
            if name not in nodes:
                raise UserError(f"{scenario.file} is about a {name}; here is {', '.join(nodes)}")
        self.scenario = scenario
        self.listeners: list[Callable[[Event], None]] = []
        self._segment = segment
        self._clock = clock = segment.clock
        self._nodes = {name: nodes[name] for name in scenario.nodes}
        self._names = {id(node): name for name, node in self._nodes.items()}
        self._wire = segment.master(NAME)
        self._begin = clock.ticks
        self._happenings = Happenings(self._nodes, clock)
        self._scenes = Scenes(self._nodes, self._time)
        self._judge = Judge(self._scenes, self._time, self._tell_outcome)
        self._clients = {
            name: Client(node, clock, self._send) for name, node in self._nodes.items()
        }
        tools = Tools(
            self._nodes,
            clock,
            self._happenings,
            self._clients,
            Healing(self._tell_fault),
            self._judge,
            self._send,
            self._tell,
        )
        self._steps = Sequencer(scenario.steps, tools, self._clean_up, scenario.duration)
        self._cleanup = Sequencer(scenario.cleanup, tools, strict=False)

    def start(self) -> None:
        """The scenario begins now; its first steps come with the next move of the clock."""
        self._begin = self._clock.ticks
        self._segment.listeners.append(self._hear)
        for name, node in self._nodes.items():
            node.listeners.append(partial(self._tell_state, name))
        for watched, sign in needs(self.scenario):
            if isinstance(sign, Entered):
                self._happenings.attend_to_states(self._nodes[watched])
            elif isinstance(sign, Written):
                self._happenings.attend_to_writes(self._nodes[watched])
        limit = self._begin + microseconds(LONGEST) + GRAIN
        self._limit = self._clock.at_tick(limit, self._steps.expire)
        self._leave_out_bit_rate()
        self._steps.start()

    @property
    def done(self) -> bool:
        """Whether every step has been carried out and every expectation decided."""
        if self.scenario.cleanup:
            return self._steps.over and self._cleanup.agenda.settled
        return self._steps.over or self._steps.agenda.settled

    @property
    def horizon(self) -> float:
        """Time of the clock before which the run is not over, unless an error ends it."""
        horizons = [sequencer.agenda.horizon for sequencer in (self._steps, self._cleanup)]
        return (max(horizons) + GRAIN) / MICROSECONDS

    @property
    def verdict(self) -> Verdict:
        """What has been found; what is not decided by now counts as an error."""
        undecided = [*self._steps.agenda.undecided, *self._cleanup.agenda.undecided]
        outcomes = self._judge.outcomes(undecided, self._clock.ticks)
        told, now = self.scenario, self._time(self._clock.ticks)
        return Verdict(str(told.file), outcomes, told.name, told.seed, seconds=now)

    def _hear(self, frame: Frame, sender: str) -> None:
        self._scenes.hear(self._clock.ticks, frame, sender)
        if frame.can_id in ANSWERS:
            for client in self._clients.values():
                client.hear(frame)
        self._happenings.hear(frame, sender)

    def _send(self, frame: Frame) -> None:
        self._wire.put(frame)
        self._segment.deliver()

    def _leave_out_bit_rate(self) -> None:
        """What only a simulated bus can do is no part of a verdict on another one."""
        scenario = self.scenario
        if scenario.bit_rate is not None and not self._segment.limited:
            step = Step(At(0), "", Limit(scenario.bit_rate), "", scenario.bit_rate_line)
            self._judge.decide(step, REAL, self._clock.ticks)

    def _clean_up(self) -> None:
        self._limit.cancel()
        self._cleanup.start()

    def _time(self, tick: int) -> float:
        return (tick - self._begin) / MICROSECONDS

    def _tell(self, node: str, kind: str, fields: Mapping[str, object]) -> None:
        event = Event(self._time(self._clock.ticks), node, kind, fields)
        for listener in self.listeners:
            listener(event)

    def _tell_state(self, node: str, state: State) -> None:
        self._tell(node, "state", {"state": str(state)})

    def _tell_fault(self, node: Node, kind: str, fields: Mapping[str, object]) -> None:
        self._tell(self._names[id(node)], kind, fields)

    def _tell_outcome(self, step: Step, outcome: Outcome) -> None:
        told = {"line": outcome.line, "what": outcome.what, "seen": outcome.seen}
        self._tell(step.node, "outcome", {"verdict": str(outcome.kind), **told})
