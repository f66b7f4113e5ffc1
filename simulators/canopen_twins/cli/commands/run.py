"""Twins on a CAN bus in real time."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

from canopen_twins import scenario as replay
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.commands.announce import Announcer
from canopen_twins.cli.commands.bus import Place, place
from canopen_twins.cli.commands.kept import kept
from canopen_twins.cli.commands.participants import participants, title
from canopen_twins.cli.commands.scenarios import load
from canopen_twins.cli.commands.signals import Wishes, signals
from canopen_twins.cli.exit_codes import FAILED, OK
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.files.whole import held
from canopen_twins.live.line import OpenBus
from canopen_twins.live.node_id_check import looking
from canopen_twins.live.serve import serve

LOOK, LONG_LOOK = 0.3, 1.5  # seconds; on a real bus a heartbeat of a second should be heard


def run(options: argparse.Namespace) -> int:
    """Serve until SIGTERM (0), SIGINT (130) or the end of the scenario (0, or 1 if it failed)."""
    with held(options.nvram) if options.nvram else nullcontext(), signals() as wishes:
        return _run(options, wishes)


def _run(options: argparse.Namespace, wishes: Wishes) -> int:
    segment: Segment[Node] = Segment()
    announcer = Announcer(options)
    if announcer.wanted and not options.scenario:
        raise UserError("--json and --junit tell of a verdict: say which with --scenario")
    scenario = load(options.scenario) if options.scenario else None
    devices = participants(options, scenario)
    nodes = {name: connect(segment, device, name) for name, device in devices.items()}
    player = replay.Player(scenario, segment, nodes) if scenario else None
    bus = place(options)
    name = title(options, scenario)
    ready = {"ready": name, **_who(name, segment), **bus.told}
    with _off_in_the_end(segment):
        with kept(options, "run", scenario, devices) as observers:
            replay.begin(segment, player, observers)
            serve(
                segment,
                _opening(bus, segment),
                lambda: bool(wishes) or (player is not None and player.done),
                lambda: print(json.dumps(ready), flush=True),
            )
        return wishes.code if player is None else _told(player, announcer, wishes)


@contextmanager
def _off_in_the_end(segment: Segment[Node]) -> Iterator[None]:
    """Whatever comes, the devices keep what they keep when their supply goes."""
    try:
        yield
    finally:
        for node in segment.nodes:
            node.power_off()


def _told(player: replay.Player, announcer: Announcer, wishes: Wishes) -> int:
    """Programs hear of a run that was stopped before its end, too."""
    if player.done or announcer.wanted:
        announcer.tell(player.verdict)
        announcer.end()
    if not player.done:
        return wishes.code
    return OK if player.verdict.ok else FAILED


def _opening(bus: Place, segment: Segment[Node]) -> OpenBus:
    """With a look whether somebody is there who has one of our node ids."""
    if bus.private:
        return bus.open
    node_ids = [node.node_id for node in segment.nodes]
    return looking(bus.open, node_ids, LOOK if bus.virtual else LONG_LOOK)


def _who(name: str, segment: Segment[Node]) -> dict[str, object]:
    """One node id, or those of all nodes of a file."""
    ids = {node.wire.name: node.node_id for node in segment.nodes}
    return {"node_id": ids[name]} if name in ids else {"nodes": ids}
