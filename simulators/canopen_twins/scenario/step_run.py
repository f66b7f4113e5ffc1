"""One step being carried out: what it does to the bus and the nodes, and what comes of it."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.scenario.actions import Clear, Inject, Nmt, Power, Read, Send, Set, Write
from canopen_twins.scenario.bus_events import WHOLE_MOMENT, BusEvents
from canopen_twins.scenario.expectation_run import Watch
from canopen_twins.scenario.matchers import Condition
from canopen_twins.scenario.run_log import RunLog
from canopen_twins.scenario.scenario import Step
from canopen_twins.scenario.sdo_client import Answer, Job, ScenarioMaster
from canopen_twins.scenario.verdict import Finding, Kind


class InjectedFaults:
    """Every fault has one end at most to come: who takes it away or replaces it calls that off."""

    def __init__(self, nodes: Mapping[str, Node], log: RunLog) -> None:
        self._nodes = nodes
        self._log = log
        self._ends: dict[tuple[str, str], object] = {}

    def inject(self, name: str, faults: Mapping[str, Mapping[str, Any]]) -> None:
        """Let things go wrong with a node, in the order of the file.

        Raises:
            UserError: the node has no such fault.
        """
        node = self._nodes[name]
        with node.acting():
            for fault, parameters in faults.items():
                node.faults.inject(fault, **parameters)
                self._ends.pop((name, fault), None)
                self._log.tell(name, "inject", fault=fault, parameters=dict(parameters))

    def clear(self, name: str, fault: str | None) -> None:
        """Take one away, or all of them; without effect if it is not active.

        Raises:
            UserError: the node has no such fault.
        """
        node = self._nodes[name]
        with node.acting():
            gone = [each for each in node.faults.active if fault in (None, each)]
            node.faults.clear(fault)
            for each in gone:
                self._ends.pop((name, each), None)
                self._log.tell(name, "clear", fault=each)

    def end(self, name: str, faults: Iterable[str]) -> Callable[[], None]:
        """What clears those of the faults that are still the same when it is called."""
        end = object()
        planned = [(name, fault) for fault in faults]
        self._ends.update(dict.fromkeys(planned, end))

        def clear() -> None:
            for key in planned:
                if self._ends.get(key) is end:
                    self.clear(*key)

        return clear


class Resources(NamedTuple):
    """What all steps of a run share."""

    bus: BusEvents
    master: ScenarioMaster
    faults: InjectedFaults
    log: RunLog


class StepRun:
    """How far a step has come; when it is carried out, its sequence says.

    `news` is called with it when the answer to something it has asked is there.
    """

    def __init__(self, step: Step, resources: Resources, news: Callable[["StepRun"], None]) -> None:
        self.step = step
        self.scheduled = False
        """Whether its moment is known."""
        self.since = WHOLE_MOMENT
        """Behind what set it off, if that was at this microsecond."""
        self.timer: Timer | None = None
        """Of the next time it is carried out."""
        self.watch: Watch | None = None
        """For the condition that is its moment."""
        self.rounds = 0
        """How often it has been carried out."""
        self.failed = False
        """Whether it could not be carried out."""
        self.lasts = 0
        """The microsecond at which what it has done ends by itself."""
        self._resources = resources
        self._news = news
        self._jobs = 0  # that the SDO client has not done yet

    @property
    def waiting(self) -> bool:
        """Whether it waits for a condition."""
        return self.watch is not None and not self.scheduled

    @property
    def done(self) -> bool:
        """Whether it has been carried out for the last time, and all it has asked is answered."""
        return self.rounds == self.step.times and not self._jobs

    def drop(self) -> None:
        """Carry it out no more."""
        if self.timer is not None:
            self.timer.cancel()
        if self.watch is not None:
            self.watch.stop()

    def act(self) -> None:
        """Do once what its action says, unless that is to expect something."""
        try:
            self._act()
        except UserError as refusal:
            self._report(Finding(Kind.ERROR, str(refusal)))

    def _act(self) -> None:
        name, (bus, master, faults, _) = self.step.node, self._resources
        match self.step.action:
            case Write() | Read() as access:
                self._ask(access)
            case Inject() as injection:
                self._inject(injection)
            case Clear(fault):
                faults.clear(name, fault)
            case Set(settings):
                with bus.nodes[name].acting() as device:
                    device.set(**settings)
            case Send(frame):
                master.send(frame)
            case Nmt(command):
                told = bytes([command, bus.nodes[name].node_id])
                master.send(Frame(identifiers.NMT, told))
            case Power(switch):
                switch(bus.nodes[name])
            case action:
                raise TypeError(f"no step carries out {action!r}")

    def _ask(self, access: Write | Read) -> None:
        """SDO transfers with the node, behind those of the steps before."""
        answers: list[Answer] = []

        def answered(answer: Answer) -> bool:
            answers.append(answer)
            if (finding := access.judge(answers)) is not None:
                self._report(finding)
            return finding is None

        self._jobs += 1
        client = self._resources.master.clients[self.step.node]
        client.ask(Job(access.transfers(), access.timeout, answered, self._answered))

    def _answered(self) -> None:
        self._jobs -= 1
        self._news(self)

    def _inject(self, injection: Inject) -> None:
        bus, _, faults, _ = self._resources
        here = bus.position
        faults.inject(self.step.node, injection.faults)
        if injection.lasts is None:
            return
        clear = faults.end(self.step.node, injection.faults)
        if isinstance(injection.lasts, Condition):
            seen = partial(self._clear_soon, clear)
            Watch.of(injection.lasts, bus, seen).listen(here)
        else:
            self.lasts = bus.clock.ticks + microseconds(injection.lasts)
            bus.clock.at_tick(self.lasts, clear)

    def _clear_soon(self, clear: Callable[[], None], told: str) -> None:
        clock = self._resources.bus.clock
        clock.at_tick(clock.ticks, clear)  # not in the middle of what happens

    def _report(self, finding: Finding) -> None:
        self._resources.log.decide(self.step, finding)
        self.failed = self.failed or finding.kind is Kind.ERROR
