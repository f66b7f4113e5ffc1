"""run: twins on a CAN bus in real time; one device, the nodes of a scenario, or of a bench file."""

import argparse
import json
import logging
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path

from can.cli import add_bus_arguments

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.cli.bus import NamedBus, add_bus, bus_of_run, join_hub
from canopen_twins.cli.check import load
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
    device_settings,
    parent,
)
from canopen_twins.cli.control import add_control, controlled
from canopen_twins.cli.results import Announcer, add_recording, add_reports, recording
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.device.settings import TimingSettings
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.files.whole import held
from canopen_twins.live.bus import OpenBus, with_node_id_check
from canopen_twins.live.master_process import MasterProcess
from canopen_twins.live.master_watch import MasterWatch
from canopen_twins.live.node_id_watch import NodeIdWatch
from canopen_twins.live.run_end import RunEnd
from canopen_twins.live.serve import serve
from canopen_twins.scenario import Player, Scenario, begin, load_bench
from canopen_twins.scenario.scenario import EndsWith, NodeSpec, Stalls
from canopen_twins.slave.memory import Memory

log = logging.getLogger(__name__)

LISTEN, LISTEN_LONG = 0.1, 1.5  # seconds; on a real bus a heartbeat of a second should be heard
OF_ONE_DEVICE = ("node-id", "set", "config", "nvram")


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
    parser.add_argument("--scenario", metavar="SCENARIO", help=SCENARIO)
    text = "keep what the device stores in a file"
    parser.add_argument("--nvram", type=Path, metavar="FILE", help=text)
    add_bus(parser)
    add_control(parser)
    text = "what becomes of periodic messages that are late after a stall (skip: sent once)"
    parser.add_argument("--stalls", choices=[str(each) for each in Stalls], help=text)
    text = "end with exit code 2 when another node on the bus has one of our node ids (on a hub)"
    parser.add_argument("--exclusive", action=argparse.BooleanOptionalAction, help=text)
    add_parent(parser)
    add_reports(parser)
    add_recording(parser)
    add_bus_arguments(parser)
    parser.set_defaults(command=run)


def run(options: argparse.Namespace) -> int:
    """Serve until a signal, the end of the scenario or that of the command beside it.

    The exit code is that of the verdict (0, or 1 if it failed); without a scenario that of the
    command; without either 0, or 130 by SIGINT.
    """
    with held(options.nvram) if options.nvram else nullcontext(), catch_signals() as signals:
        return _run(options, signals)


def _run(options: argparse.Namespace, signals: Signals) -> int:
    segment: Segment[Node] = Segment()
    announcer = Announcer(options)
    if announcer.wanted and not options.scenario:
        raise UserError("--json and --junit tell of a verdict: say which with --scenario")
    scenario = load(options.scenario) if options.scenario else None
    participants = _participants(options, scenario)
    nodes = {name: connect(segment, device, name) for name, device in participants.items()}
    player = _player(options, scenario, segment, nodes)
    _tune(segment, getattr(options, "bitrate", None))
    segment.clock.catches_up = _catches_up(options, scenario)
    served = parent(options)
    with (
        _off_in_the_end(segment),
        bus_of_run(options) as bus,
        controlled(options, segment, player, _title(options, scenario)) as control,
        _beside(options, bus) as master,
    ):
        doubles = NodeIdWatch(segment, player)
        exclusive = _exclusive(options, bus)
        end = RunEnd(lambda: bool(signals), player, master, served, doubles if exclusive else None)
        with recording(options, "run", scenario, participants) as observers:
            begin(segment, player, observers)
            ready = {**_ready(_title(options, scenario), segment), **bus.told, **control.told}
            opening = _opening(bus, segment, options.exclusive)
            watch = MasterWatch(segment, player)
            serve(segment, opening, end, partial(_begin, ready, master, watch), control.orders)
        code = _code_of(master, signals) if player is None else _told(player, announcer, signals)
    if exclusive and doubles.found:
        raise UserError("ended: a node id belongs to one node alone (--no-exclusive goes on)")
    return code


def _player(
    options: argparse.Namespace,
    scenario: Scenario | None,
    segment: Segment[Node],
    nodes: Mapping[str, Node],
) -> Player | None:
    if scenario is None:
        return None
    until_told = bool(options.words) and scenario.ends_with is EndsWith.COMMAND
    return Player(scenario, segment, nodes, until_told)


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


def _begin(ready: Mapping[str, object], master: MasterProcess | None, watch: MasterWatch) -> None:
    """All is on the bus."""
    watch.start()
    print(json.dumps(ready), flush=True)
    if master is not None:
        master.start()


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


def _ready(title: str, segment: Segment[Node]) -> dict[str, object]:
    """What is run, with one node id, or with those of all nodes of a file."""
    ids = {node.wire.name: node.node_id for node in segment.nodes}
    said = {"node_id": ids[title]} if title in ids else {"nodes": ids}
    rates = {node.device.bit_rate for node in segment.nodes if node.device.files} - {None}
    if len(rates) > 1:
        told = " and ".join(f"{rate} bit/s" for rate in sorted(filter(None, rates)))
        log.warning("the files of %s are for %s: one bus has one bit rate", title, told)
    return {"ready": title, **said, **({"bit_rate": rates.pop()} if len(rates) == 1 else {})}


def _title(options: argparse.Namespace, scenario: Scenario | None) -> str:
    """As it was called, or the only node of a scenario, or the scenario."""
    if options.device is not None or scenario is None:
        return str(options.device)
    return next(iter(scenario.nodes)) if len(scenario.nodes) == 1 else str(scenario.file)


def _participants(options: argparse.Namespace, scenario: Scenario | None) -> dict[str, Device]:
    """The devices by the names of their nodes, with their power off.

    Raises:
        UserError: there is no such device or file, or it cannot be as it is told to be.
    """
    name = options.device or ""
    if not devices.tells_of_device(name) and ("/" in name or name.endswith((".yaml", ".yml"))):
        _refuse(options, options.device, (*OF_ONE_DEVICE, "scenario"))
        return {name: _real(spec).create() for name, spec in _of_bench(options.device).items()}
    if scenario is not None:
        return _of_scenario(options, scenario)
    if options.device is None:
        taken = f"; {options.hub} was taken for the hub" if options.hub in devices.names() else ""
        hint = f"say which device, or --scenario with a file that does{taken}"
        raise UserError(f"nothing to run: {hint}")
    spec = _real(NodeSpec(devices.find(options.device), {}))
    return {options.device: _equipped(options, spec)}


def _of_bench(name: str) -> Mapping[str, NodeSpec]:
    try:
        return load_bench(Path(name))
    except UserError as refusal:
        try:
            load(name)
        except UserError:
            raise refusal from None
    raise UserError(f"{name} is a scenario: run --scenario {name}")


def _of_scenario(options: argparse.Namespace, scenario: Scenario) -> dict[str, Device]:
    about = f"{scenario.file} is about {', '.join(scenario.nodes)}"
    if options.device not in (None, *scenario.nodes):
        raise UserError(f"{about}, not about {options.device}")
    if len(scenario.nodes) == 1:
        return {name: _equipped(options, spec) for name, spec in scenario.nodes.items()}
    if options.device is not None:
        raise UserError(f"{about}: leave {options.device} out, and all of them are run")
    _refuse(options, str(scenario.file), OF_ONE_DEVICE)
    return {name: spec.create() for name, spec in scenario.nodes.items()}


def _refuse(options: argparse.Namespace, file: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(options, name.replace("-", "_")):
            raise UserError(f"{file} says all about its nodes: leave --{name} out")


def _real(spec: NodeSpec) -> NodeSpec:
    """With the times of a real device, unless it says others; a scenario is judged by its own."""
    timed = isinstance(spec.device.settings, TimingSettings)
    usual = {"timing": "typical"} if timed else {}
    return NodeSpec(spec.device, {**usual, **spec.settings})


def _equipped(options: argparse.Namespace, spec: NodeSpec) -> Device:
    """With what the command line has to say, which is the last word."""
    device = spec.device(**{**spec.settings, **device_settings(options)})
    if options.nvram is not None:
        device.memory = Memory(options.nvram)
    return device
