"""run: twins on a CAN bus in real time; one device, the nodes of a scenario, or of a bench file."""

from __future__ import annotations

import argparse
import json
import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from can.cli import add_bus_arguments

from canopen_twins.bus.clock import Stalls
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.bus import NamedBus, add_bus, bus_of_run, hub_of_options, join_hub
from canopen_twins.cli.command import (
    DEVICE,
    FAILED,
    INTERRUPTED,
    OK,
    SCENARIO,
    SIGNALLED,
    Parser,
    Signals,
    add_device,
    add_parent,
    catch_signals,
    parent,
)
from canopen_twins.cli.control import Control, add_control, controlled
from canopen_twins.cli.participants import participants_of, title
from canopen_twins.cli.results import Announcer, add_recording, add_reports, recording
from canopen_twins.cli.telling import StateOnDemand, add_words, telling
from canopen_twins.cli.tolerances import add_tolerances
from canopen_twins.device.boot import switch_on
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.files.whole import held
from canopen_twins.live import garbage
from canopen_twins.live.bus import OpenBus, with_node_id_check
from canopen_twins.live.hub_process import Hub
from canopen_twins.live.master_process import MasterProcess
from canopen_twins.live.master_watch import MasterWatch
from canopen_twins.live.node_id_watch import NodeIdWatch
from canopen_twins.live.run_end import RunEnd
from canopen_twins.live.serve import serve

if TYPE_CHECKING:
    from canopen_twins.scenario import Player, Scenario

log = logging.getLogger(__name__)

LONGEST_START = 2.0  # seconds; whoever is not on the bus by then is told of
LISTEN, LISTEN_LONG = 0.1, 1.5  # seconds; on a real bus a heartbeat of a second should be heard


def add_run(parser: Parser) -> None:
    """run."""
    text = f"{DEVICE}, or a bench file; with --scenario it may be left out"
    add_device(parser, text, nargs="?")
    parser.epilog = (
        "With -- COMMAND a master is started beside the twins when they are on the bus. It finds"
        " the bus where it says {interface}, {channel} and {hub}, and in its environment. Booting,"
        " answering, storing and measuring take the times of --set timing=typical, unless a file or"
        " --set says otherwise; timing=ideal is none. A scenario has its own."
    )
    parser.takes_command = True
    parser.usage = "%(prog)s [OPTION ...] [DEVICE] [-- COMMAND ...]"
    parser.add_argument("--scenario", metavar="SCENARIO", help=SCENARIO)
    text = "keep what the device stores in a file"
    parser.add_output("--nvram", text)
    add_bus(parser)
    add_control(parser)
    text = "what becomes of periodic messages that are late after a stall (skip: sent once)"
    parser.add_argument("--stalls", choices=[str(each) for each in Stalls], help=text)
    text = "end with exit code 2 when another node on the bus has one of our node ids (on a hub)"
    parser.add_argument("--exclusive", action=argparse.BooleanOptionalAction, help=text)
    text = "beside the real device: send nothing, and tell where the device differs from its twin"
    parser.add_argument("--shadow", action="store_true", help=text)
    add_tolerances(parser)
    add_parent(parser)
    add_reports(parser)
    add_recording(parser)
    add_words(parser)
    add_bus_arguments(parser)
    parser.set_defaults(command=run)


def run(options: argparse.Namespace) -> int:
    """Serve until a signal, the end of the scenario or that of the command beside it.

    The exit code is that of the verdict (0, or 1 if it failed); without a scenario that of the
    command; without either 0, or 130 by SIGINT.
    """
    if options.shadow:
        with catch_signals() as signals:
            return _shadow(options, signals)
    with held(options.nvram) if options.nvram else nullcontext(), catch_signals() as signals:
        return _run(options, signals)


def _shadow(options: argparse.Namespace, signals: Signals) -> int:
    # comparing needs pydantic, which a run without a file does not
    from canopen_twins.cli.shadow import run_shadow  # noqa: PLC0415

    return run_shadow(options, signals)


class Prepared(NamedTuple):
    """Who is run, with the power off."""

    segment: Segment[Node]
    scenario: Scenario | None
    participants: Mapping[str, Device]
    player: Player | None


def _prepared(options: argparse.Namespace) -> Prepared:
    segment: Segment[Node] = Segment()
    scenario = _scenario(options) if options.scenario else None
    participants = participants_of(options, scenario)
    nodes = {name: connect(segment, device, name) for name, device in participants.items()}
    player = _player(options, scenario, segment, nodes) if scenario is not None else None
    _tune(segment, getattr(options, "bitrate", None))
    segment.clock.catches_up = _catches_up(options, scenario)
    return Prepared(segment, scenario, participants, player)


def _scenario(options: argparse.Namespace) -> Scenario:
    # twins without a scenario start without what plays one: half of what there is to import
    from canopen_twins.cli.scenario_file import load  # noqa: PLC0415

    return load(options.scenario)


def _player(
    options: argparse.Namespace,
    scenario: Scenario,
    segment: Segment[Node],
    nodes: Mapping[str, Node],
) -> Player:
    from canopen_twins.scenario import Player  # noqa: PLC0415 - as above

    return Player(scenario, segment, nodes, bool(options.words) and scenario.ends_with_command)


def _run(options: argparse.Namespace, signals: Signals) -> int:
    announcer = Announcer(options)
    if announcer.wanted and not options.scenario:
        raise UserError("--json and --junit tell of a verdict: say which with --scenario")
    with hub_of_options(options) as hub:  # it starts while the twins are made
        return _on_a_bus(options, signals, _prepared(options), hub, announcer)


def _on_a_bus(
    options: argparse.Namespace,
    signals: Signals,
    run: Prepared,
    hub: Hub | None,
    announcer: Announcer,
) -> int:
    segment, player, served = run.segment, run.player, parent(options)
    bus = bus_of_run(options, hub)
    with (
        _off_in_the_end(segment),
        controlled(options, segment, player, title(options, run.scenario)) as control,
        _beside(options, bus) as master,
    ):
        doubles, state = NodeIdWatch(segment, player), StateOnDemand(segment, signals)
        exclusive = _exclusive(options, bus)

        def told_to_end() -> bool:
            state.tell_if_asked()
            return bool(signals)

        end = RunEnd(told_to_end, player, master, served, doubles if exclusive else None)
        _serve(options, run, bus, control, end)
        code = _code_of(master, signals) if player is None else _told(player, announcer, signals)
    if exclusive and doubles.found:
        raise UserError("ended: a node id belongs to one node alone (--no-exclusive goes on)")
    return code


def _serve(
    options: argparse.Namespace, run: Prepared, bus: NamedBus, control: Control, end: RunEnd
) -> None:
    """From power-on to the end."""
    segment, scenario = run.segment, run.scenario
    with (
        recording(options, "run", scenario, run.participants) as observers,
        telling(options) as told,
    ):
        for attach in (*observers, *told.observers):
            attach(segment, run.player)
        switch_on(segment, None if run.player is None else run.player.start)
        silent = _silent(segment)
        ready = {
            **_ready(title(options, scenario), segment),
            **({"silent": silent} if silent else {}),
            **bus.told,
            **control.told,
        }
        watch = MasterWatch(segment, run.player)

        def on_the_bus() -> None:
            print(json.dumps(ready), flush=True)
            told.start()
            watch.start()
            segment.clock.after(LONGEST_START, partial(_tell_silent, segment))
            end.begin()

        open_bus = _opening(bus, segment, options.exclusive)
        with garbage.in_portions():
            serve(segment, open_bus, end, on_the_bus, control.orders)


def _catches_up(options: argparse.Namespace, scenario: Scenario | None) -> bool:
    told = Stalls.SKIP if scenario is None else scenario.stalls
    return (options.stalls or told) == Stalls.CATCH_UP


@contextmanager
def _beside(options: argparse.Namespace, bus: NamedBus) -> Iterator[MasterProcess | None]:
    """The command beside the twins, if there is one; it does not outlive them."""
    master = MasterProcess(options.words, bus.place) if options.words else None
    try:
        yield master
    finally:
        if master is not None:
            master.end()


def _code_of(master: MasterProcess | None, signals: Signals) -> int:
    """As shells have it of what was ended by a signal, and if it is by us, what ended us."""
    if master is None or signals:
        return signals.code
    code = master.code or 0
    return code if code >= 0 else SIGNALLED - code


def _tune(segment: Segment[Node], bit_rate: int | None) -> None:
    """A node that is set to another bit rate than `--bitrate` neither hears nor is heard."""
    segment.bit_rate = bit_rate
    for node in segment.nodes:
        own = node.device.bit_rate
        if None not in (own, bit_rate) and own != bit_rate:
            name = node.wire.name
            log.warning("%s has %d bit/s, the bus %d: they do not meet", name, own, bit_rate)


@contextmanager
def _off_in_the_end(segment: Segment[Node]) -> Iterator[None]:
    """Whatever comes, the devices keep what they keep when their supply goes."""
    try:
        yield
    finally:
        for node in segment.nodes:
            node.power_off()


def _told(player: Player, announcer: Announcer, signals: Signals) -> int:
    """The verdict, whatever has ended the run; Ctrl-C before anything is judged is none."""
    verdict = player.verdict
    announcer.tell(verdict)
    announcer.end()
    if signals.code == INTERRUPTED and not player.judged:
        return INTERRUPTED
    return OK if verdict.ok else FAILED


def _exclusive(options: argparse.Namespace, bus: NamedBus) -> bool:
    """Whether nobody else may have one of our node ids; on a hub, where all are ours, so it is."""
    return bus.place.hub is not None if options.exclusive is None else bool(options.exclusive)


def _opening(bus: NamedBus, segment: Segment[Node], exclusive: bool | None) -> OpenBus:
    """With a look whether somebody is there who has one of our node ids; a hub knows by itself."""
    if bus.private or exclusive is False:
        return bus.open
    open_bus, node_ids = bus.open, [node.node_id for node in segment.nodes]
    if bus.place.hub is not None:
        open_bus = partial(join_hub, bus.place.hub, bus.place.channel, node_ids)
    return with_node_id_check(open_bus, node_ids, LISTEN if bus.virtual else LISTEN_LONG)


def _silent(segment: Segment[Node]) -> dict[str, str]:
    """Who is not on the bus, and why."""
    nodes = [node for node in segment.nodes if not node.device.online]
    return {node.wire.name: node.device.silence for node in nodes}


def _tell_silent(segment: Segment[Node]) -> None:
    for name, why in _silent(segment).items():
        log.warning("%s is still not on the bus: %s", name, why)


def _ready(title: str, segment: Segment[Node]) -> dict[str, object]:
    """What is run, with one node id, or with those of all nodes of a file."""
    ids = {node.wire.name: node.node_id for node in segment.nodes}
    said = {"node_id": ids[title]} if title in ids else {"nodes": ids}
    rates = {node.device.bit_rate for node in segment.nodes if node.device.files} - {None}
    if len(rates) > 1:
        told = " and ".join(f"{rate} bit/s" for rate in sorted(filter(None, rates)))
        log.warning("the files of %s are for %s: one bus has one bit rate", title, told)
    return {"ready": title, **said, **({"bit_rate": rates.pop()} if len(rates) == 1 else {})}
