"""One step being carried out: what it does to the bus and the nodes, and what comes of it."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.scenario.actions import Clear, Inject, Nmt, Power, Read, Send, Set, Wait, Write
from canopen_twins.scenario.bus_events import WHOLE_MOMENT, BusEvents
from canopen_twins.scenario.expectation_run import Watch
from canopen_twins.scenario.matchers import Condition
from canopen_twins.scenario.run_log import RunLog
from canopen_twins.scenario.scenario import Step
from canopen_twins.scenario.sdo_client import Answer, ScenarioMaster, SdoClient, Talk
from canopen_twins.scenario.verdict import Finding, Kind


class InjectedFaults:
    """Knows which injection a fault is of: who takes it away or replaces it calls its end off."""

    def __init__(self, nodes: Mapping[str, Node], log: RunLog) -> None:
        self._nodes = nodes
        self._log = log
        self._injections: dict[tuple[str, str], object] = {}

    def inject(self, name: str, faults: Mapping[str, Mapping[str, Any]]) -> Callable[[], None]:
        """Let things go wrong with a node; what clears, when called, those that are still the same.

        Raises:
            UserError: the node has no such fault.
        """
        node, injection = self._nodes[name], object()
        with node.acting():
            for fault, parameters in faults.items():
                node.faults.inject(fault, **parameters)
                self._injections[name, fault] = injection
                self._log.tell(name, "inject", fault=fault, parameters=dict(parameters))
        return partial(self._end, name, faults, injection)

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
                self._injections.pop((name, each), None)
                self._log.tell(name, "clear", fault=each)

    def _end(self, name: str, faults: Iterable[str], injection: object) -> None:
        for fault in faults:
            if self._injections.get((name, fault)) is injection:
                self.clear(name, fault)


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
        self._asking = 0  # talks that the SDO client is not through with

    @property
    def waiting(self) -> bool:
        """Whether it waits for a condition."""
        return self.watch is not None and not self.scheduled

    @property
    def done(self) -> bool:
        """Whether it has been carried out for the last time, and all it has asked is answered."""
        return self.rounds == self.step.times and not self._asking

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
                self._asking += 1
                client = master.clients[name]
                client.ask(self._ask(access, client))
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
            case Wait():
                pass
            case action:
                raise TypeError(f"no step carries out {action!r}")

    def _ask(self, access: Write | Read, client: SdoClient) -> Talk:
        """One transfer after the other; what ends the step ends them."""
        answers: list[Answer] = []
        for transfer in access.transfers():
            answers.append((yield from client.make(transfer, access.timeout)))
            if (finding := access.judge(answers)) is not None:
                self._report(finding)
                break
        self._asking -= 1
        self._news(self)

    def _inject(self, injection: Inject) -> None:
        bus, _, faults, _ = self._resources
        here = bus.position
        end = faults.inject(self.step.node, injection.faults)
        if isinstance(injection.lasts, Condition):
            Watch.of(injection.lasts, bus, partial(self._end_soon, end)).listen(here)
        elif injection.lasts is not None:
            self.lasts = bus.clock.ticks + microseconds(injection.lasts)
            bus.clock.at_tick(self.lasts, end)

    def _end_soon(self, end: Callable[[], None], told: str) -> None:
        clock = self._resources.bus.clock
        clock.at_tick(clock.ticks, end)  # not in the middle of what happens

    def _report(self, finding: Finding) -> None:
        self._resources.log.decide(self.step, finding)
        self.failed = self.failed or finding.kind is Kind.ERROR
