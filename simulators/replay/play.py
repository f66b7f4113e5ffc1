"""Plays a scenario in simulated time, and writes what was on the bus."""

from collections.abc import Callable
from typing import TextIO

from simulators.clock import Clock
from simulators.replay.player import Player
from simulators.replay.scenario import Scenario
from simulators.replay.verdict import Verdict
from simulators.segment import Record, Segment
from simulators.wire import Frame

SLICE = 1.0  # seconds between two reports of progress


def play(
    scenario: Scenario,
    trace: TextIO | None = None,
    progress: Callable[[float], None] = lambda now: None,
) -> Verdict:
    """Power on, every step, every expectation to the end of its time, and the verdict.

    Args:
        scenario: What to play; it stays as it is.
        trace: Takes every frame in the format of `candump -L`, with simulated time.
        progress: Called with the simulated time in seconds, once a second of it or more often.
    """
    segment = Segment()
    if scenario.bit_rate is not None:
        segment.limit(scenario.bit_rate)
    nodes = {name: segment.node(spec.create(), name) for name, spec in scenario.nodes.items()}

    def write(frame: Frame, sender: str) -> None:
        if trace is not None:
            trace.write(f"{Record(segment.clock.now, frame, sender)}\n")

    segment.listeners.append(write)
    player = Player(scenario, segment, nodes)
    player.start()
    for node in nodes.values():
        node.power_on()
    segment.deliver()
    while not player.done or segment.clock.now < player.horizon:
        segment.advance_to(_next(segment.clock, player.horizon))
        progress(segment.clock.now)
    return player.verdict


def _next(clock: Clock, horizon: float) -> float:
    """As far as the run cannot be over; from there on by one deadline at a time."""
    end = horizon if clock.now < horizon else clock.next_deadline
    return min(end, clock.now + SLICE)
