"""How a run begins and ends: a scenario in simulated time, from power-on to its verdict."""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import TextIO, TypeVar

from canopen_twins.bench.bench import Bench
from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.device.boot import switch_on
from canopen_twins.device.node import Node
from canopen_twins.faults import connect
from canopen_twins.scenario.player import Player
from canopen_twins.scenario.scenario import Scenario
from canopen_twins.scenario.verdict import Verdict

AnyPlayer = TypeVar("AnyPlayer", bound=Player | None)

SLICE = 1.0  # seconds between two reports of progress


def play(
    scenario: Scenario,
    trace: TextIO | None = None,
    observers: Iterable[Callable[[Segment[Node], Player], None]] = (),
    progress: Callable[[float], None] = lambda now: None,
) -> Verdict:
    """Power on, every step, every expectation to the end of its time, and the verdict.

    The master of the file, if it names one, begins when the nodes have booted.

    Args:
        scenario: What to play; it stays as it is.
        trace: Takes every frame in the format of `candump -L`, with simulated time.
        observers: Called with the bus and its player before anything happens.
        progress: Called with the simulated time in seconds, once a second of it or more often.

    Raises:
        UserError: the master cannot be run.
    """
    segment: Segment[Node] = Segment()
    if scenario.bit_rate is not None:
        segment.limit(scenario.bit_rate)
    segment.first = scenario.arbitration
    nodes = {name: connect(segment, spec.create(), name) for name, spec in scenario.nodes.items()}
    player = Player(scenario, segment, nodes)
    begin(segment, player, observers if trace is None else [print_frames(trace), *observers])
    with _running(scenario, segment, player) as whereabouts:
        player.whereabouts = whereabouts
        segment.deliver()
        finish(player, segment, progress)
    return player.verdict


def _running(
    scenario: Scenario, segment: Segment[Node], player: Player
) -> AbstractContextManager[Callable[[], str]]:
    if scenario.master is None:
        return nullcontext(lambda: "")
    return scenario.master.running(
        segment, player.tell_of_master, scenario.seed, player.tell_of_processes
    )


def begin(
    segment: Segment[Node],
    player: AnyPlayer,
    observers: Iterable[Callable[[Segment[Node], AnyPlayer], None]] = (),
) -> None:
    """Switch the nodes of a segment on, when everybody is there who wants to hear them boot."""
    for attach in observers:
        attach(segment, player)
    switch_on(segment, None if player is None else player.start)


def print_frames(file: TextIO) -> Callable[[Segment[Node], object], None]:
    """An observer that writes every frame to a text file as `candump -L` does."""

    def attach(segment: Segment[Node], player: object) -> None:
        def hear(frame: Frame, sender: str) -> None:
            file.write(f"{Record(segment.clock.now, frame, sender)}\n")

        segment.listeners.append(hear)

    return attach


def finish(
    player: Player, segment: Segment[Node], progress: Callable[[float], None] = lambda now: None
) -> None:
    """Let time pass until a scenario that has been started is over."""
    while not player.done or segment.clock.now < player.horizon:
        segment.advance_to(_next(segment.clock, player.horizon))
        progress(segment.clock.now)


def _next(clock: Clock, horizon: float) -> float:
    """As far as the run cannot be over; from there on by one deadline at a time."""
    end = horizon if clock.now < horizon else clock.next_deadline
    return min(end, clock.now + SLICE)


class ScenarioBench(Bench):
    """The twins of a scenario with power on, and its steps on their clock.

    Whoever moves the clock meets what happens: `bench.run(5)`, or a master in simulated time.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        super().__init__({name: spec.create() for name, spec in scenario.nodes.items()})

    def _begin(self) -> None:
        scenario = self._scenario
        if scenario.bit_rate is not None:
            self.segment.limit(scenario.bit_rate)
        self.segment.first = scenario.arbitration
        nodes = {name: twin.node for name, twin in self.twins.items()}
        self._player = Player(scenario, self.segment, nodes)
        begin(self.segment, self._player, ())
        self.segment.deliver()

    @property
    def done(self) -> bool:
        """Whether every step has been carried out and every expectation decided."""
        return self._player.done

    @property
    def verdict(self) -> Verdict:
        """What has been found so far; what is not decided by now counts as an error."""
        return self._player.verdict

    def finish(self) -> None:
        """Let time pass until it is done."""
        finish(self._player, self.segment)
