"""Twins on a CAN bus in real time."""

import argparse
import json
from contextlib import nullcontext

from simulators import replay
from simulators.commands.bus import Place, place
from simulators.commands.cast import cast, title
from simulators.commands.lock import held
from simulators.commands.scenarios import load
from simulators.commands.signals import OK, Wishes, signals
from simulators.line import OpenBus
from simulators.lookout import looking
from simulators.segment import Segment
from simulators.serve import serve

FAILED = 1
LOOK, LONG_LOOK = 0.3, 1.5  # seconds; on a real bus a heartbeat of a second should be heard


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM (0), SIGINT (130) or the end of the scenario (0, or 1 if it failed)."""
    with held(options.nvram) if options.nvram else nullcontext(), signals() as wishes:
        return _run(options, wishes)


def _run(options: argparse.Namespace, wishes: Wishes) -> int:
    segment = Segment()
    scenario = load(options.scenario) if options.scenario else None
    nodes = {name: segment.node(device, name) for name, device in cast(options, scenario).items()}
    bus = place(options)
    player = replay.Player(scenario, segment, nodes) if scenario else None
    if player is not None:
        player.start()
    for node in nodes.values():
        node.power_on()
    name = title(options, scenario)
    ready = {"ready": name, **_who(name, segment), **bus.told}
    serve(
        segment,
        _opening(bus, segment),
        lambda: bool(wishes) or (player is not None and player.done),
        lambda: print(json.dumps(ready), flush=True),
    )
    if player is not None and player.done:
        print(player.verdict)
        return OK if player.verdict.ok else FAILED
    return wishes.code


def _opening(bus: Place, segment: Segment) -> OpenBus:
    """With a look whether somebody is there who has one of our node ids."""
    if bus.private:
        return bus.open
    node_ids = [node.node_id for node in segment.nodes]
    return looking(bus.open, node_ids, LOOK if bus.virtual else LONG_LOOK)


def _who(name: str, segment: Segment) -> dict[str, object]:
    """One node id, or those of all nodes of a file."""
    ids = {node.wire.name: node.node_id for node in segment.nodes}
    return {"node_id": ids[name]} if name in ids else {"nodes": ids}
