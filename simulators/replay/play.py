"""Plays a scenario in simulated time, and writes what was on the bus."""

from collections.abc import Callable, Iterable
from typing import TextIO

from simulators.clock import MICROSECONDS
from simulators.replay.player import Player
from simulators.replay.scenario import Scenario
from simulators.replay.verdict import Verdict
from simulators.replay.window import GRAIN
from simulators.segment import Record, Segment
from simulators.wire import Frame


def play(
    scenario: Scenario,
    trace: TextIO | None = None,
    observers: Iterable[Callable[[Segment, Player], None]] = (),
) -> Verdict:
    """Power on, every step until the last expectation is over, and the verdict.

    Args:
        scenario: What to play; it stays as it is.
        trace: Takes every frame in the format of `candump -L`, with simulated time.
        observers: Called with the bus and its player before anything happens.
    """
    segment = Segment()
    nodes = {name: segment.node(spec.create(), name) for name, spec in scenario.nodes.items()}

    def write(frame: Frame, sender: str) -> None:
        if trace is not None:
            trace.write(f"{Record(segment.clock.now, frame, sender)}\n")

    segment.listeners.append(write)
    player = Player(scenario, segment, nodes)
    for attach in observers:
        attach(segment, player)
    player.start()
    for node in nodes.values():
        node.power_on()
    segment.deliver()
    segment.advance_to(scenario.duration + GRAIN / MICROSECONDS)
    return player.verdict
