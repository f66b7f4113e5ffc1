"""Lives through a recorded run again, in simulated time."""

from collections.abc import Iterable

from simulators.mischief import connect
from simulators.node import Node
from simulators.record.recorded import Recorded
from simulators.record.trace import Observer
from simulators.replay import Player, begin, play
from simulators.segment import Segment


def reproduce(recorded: Recorded, observers: Iterable[Observer]) -> None:
    """The same devices and scenario, and what the record has heard from outside at its times.

    Raises:
        UserError: the record is damaged, or there is no such device any more.
    """
    scenario = recorded.load_scenario()
    if scenario is not None and recorded.about.kind == "play":
        play(scenario, observers=observers)
        return
    segment: Segment[Node] = Segment()
    heard = recorded.heard
    nodes = {part.name: connect(segment, part.create(), part.name) for part in recorded.about.nodes}
    player = Player(scenario, segment, nodes) if scenario else None
    begin(segment, player, observers)
    segment.deliver()
    for time, frame in heard:
        segment.advance_to(time)
        segment.send(frame)
    segment.advance_to(recorded.end)
