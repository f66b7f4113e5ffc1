"""A run in real time: the twins of a scenario on a hub, and beside them a command, the master."""

import os
import subprocess
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import count

from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.faults import connect
from canopen_twins.live.master_process import BusPlace, MasterProcess
from canopen_twins.live.run_end import RunEnd
from canopen_twins.live.serve import serve
from canopen_twins.scenario import Player, Scenario, Verdict, begin

RUNS = count(1)  # each on a bus of its own


def play_beside(
    scenario: Scenario,
    command: Sequence[str],
    hub: str,
    observers: Iterable[Callable[[Segment[Node], Player], None]] = (),
) -> Verdict:
    """Start the command when the twins are on the bus, and end it when the scenario is over.

    Args:
        scenario: What is played.
        command: A program and its arguments, told where the bus is.
        hub: `HOST:PORT` of a hub that is there.
        observers: As for `play`.

    Raises:
        UserError: there is no such program.
    """
    segment: Segment[Node] = Segment()
    nodes = {name: connect(segment, spec.create(), name) for name, spec in scenario.nodes.items()}
    player = Player(scenario, segment, nodes)
    address, channel = HubAddress.parse(hub), f"hunt-{os.getpid()}-{next(RUNS)}"
    silent = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    master = MasterProcess(command, BusPlace.on_hub(address, channel), **silent)
    begin(segment, player, observers)
    end = RunEnd(lambda: False, player, master)
    try:
        serve(segment, partial(HubBus, address, channel), end, end.begin)
    finally:
        master.end()
        for node in segment.nodes:
            node.power_off()
    return player.verdict
