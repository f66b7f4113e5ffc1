"""The bus of `run`: one of python-can, or one on a hub."""

import argparse
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from configparser import Error as ConfigParserError
from contextlib import contextmanager, suppress
from errno import EAFNOSUPPORT, ENODEV
from functools import partial
from typing import Any, NamedTuple

import can
from can.cli import create_bus_from_namespace
from can.util import load_config

from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.cli.command import Parser
from canopen_twins.errors import UserError
from canopen_twins.live.bus import OpenBus
from canopen_twins.live.hub_process import Hub, hub_of_run, hub_started
from canopen_twins.live.master_process import BusPlace

DEFAULT_BUS = "vcan0"  # on a hub
USUAL_HUB = HubAddress()

NO_CAN = (EAFNOSUPPORT, ENODEV)
"""Of a machine without CAN sockets, or without such an interface."""
BRINGS_ONE = "`canopen-twin vcan -- COMMAND` brings a vcan0 for a command, --hub needs none"
VIRTUAL: Mapping[str, Callable[[Mapping[str, Any]], bool]] = {
    "virtual": lambda _: True,
    "udp_multicast": lambda _: True,
    "socketcan": lambda config: str(config.get("channel")).startswith(("vcan", "vxcan")),
    "socketcand": lambda config: HubAddress(str(config.get("host"))).is_loopback,
}
"""Interfaces of python-can behind which there may be no hardware, by their configuration."""


def add_bus(parser: Parser) -> None:
    """A hub or a bus of python-can."""
    else_own = ", or one of this run alone: with a COMMAND, or if there is none"
    default = f"{USUAL_HUB}{else_own if parser.takes_command else ''}"
    text = f"join a hub (default: {default}); the bus is that of -c"
    parser.add_argument("--hub", nargs="?", const="", metavar="HOST:PORT", help=text)
    parser.add_argument(
        "--real-bus", action="store_true", help="the bus may have real devices on it"
    )


class NamedBus(NamedTuple):
    """A bus that can be opened, again and again."""

    open: OpenBus
    told: Mapping[str, object]
    """What programs are told of it."""
    place: BusPlace
    """Where a master finds it."""
    virtual: bool
    """Whether there is no hardware on it."""
    private: bool = False
    """Whether nobody from another process can be on it."""


@contextmanager
def hub_of_options(options: argparse.Namespace) -> Iterator[Hub | None]:
    """With `--hub` alone there is a hub meanwhile, if there is none; it starts while others go on.

    A master that is told where its hub is meets no other run on it.
    """
    if options.hub != "" or "interface" in options:
        yield None
        return
    with hub_started() if options.words else hub_of_run(USUAL_HUB) as hub:
        yield hub


def bus_of_run(options: argparse.Namespace, hub: Hub | None) -> NamedBus:
    """The bus of the options; waits for a hub of this run.

    Raises:
        UserError: they contradict each other, or name a real bus without saying so; the hub does
            not start.
    """
    if hub is not None:
        options.hub = str(hub())
    bus = named_bus(options)
    if options.words and bus.private:
        raise UserError("no other process can join a virtual bus: say --hub with a COMMAND")
    return bus


def named_bus(options: argparse.Namespace) -> NamedBus:
    """The bus of the options; raises as `bus_of_run` does."""
    bus = _of_python_can(options) if options.hub is None else _of_a_hub(options)
    if not bus.virtual and not options.real_bus:
        where = " ".join(str(word) for word in bus.told.values() if word is not None)
        raise UserError(f"there may be real devices on {where}: say --real-bus if you mean it")
    return bus


def _check_hub(options: argparse.Namespace) -> None:
    if options.hub is not None and "interface" in options:
        raise UserError("--hub is a bus by itself: leave --interface out")


def _of_a_hub(options: argparse.Namespace) -> NamedBus:
    _check_hub(options)
    address, name = HubAddress.parse(options.hub), getattr(options, "channel", DEFAULT_BUS)
    told = {"hub": str(address), "channel": name}
    place = BusPlace.on_hub(address, name)
    return NamedBus(partial(join_hub, address, name), told, place, virtual=address.is_loopback)


def _of_python_can(options: argparse.Namespace) -> NamedBus:
    config = _config(options)
    interface = config.get("interface")
    known = VIRTUAL.get(str(interface))
    virtual = interface is None if known is None else known(config)  # None: it will not open
    told = {"interface": interface, "channel": config.get("channel")}
    place = BusPlace(str(interface), str(config.get("channel")))
    return NamedBus(partial(_open, options), told, place, virtual, interface == "virtual")


def _config(options: argparse.Namespace) -> Mapping[str, Any]:
    """What python-can makes of the options and of its configuration files; empty if it cannot.

    Raises:
        UserError: a file or CAN_CONFIG is none.
    """
    given = {key: getattr(options, key) for key in ("interface", "channel") if key in options}
    _check_environment(os.environ.get("CAN_CONFIG", "{}"))
    try:
        return load_config(config={**given, **getattr(options, "bus_kwargs", {})})
    except ConfigParserError as failure:
        words = " ".join(str(failure).split())
        raise UserError(f"the configuration of python-can: {words}") from failure
    except (can.CanError, ValueError):
        return given


def _check_environment(told: str) -> None:
    with suppress(ValueError):
        if isinstance(json.loads(told), dict):
            return
    raise UserError(f"CAN_CONFIG is a JSON object of options of python-can, not {told}")


def _open(options: argparse.Namespace) -> can.BusABC:
    """What python-can raises says why there is no bus."""
    try:
        return create_bus_from_namespace(options)
    except argparse.ArgumentError as failure:
        raise can.CanInitializationError(_told(failure.__cause__, options)) from failure


def _told(cause: BaseException | None, options: argparse.Namespace) -> str:
    """Why a bus cannot be opened, and what to do about it."""
    if isinstance(cause, OSError) and cause.errno in NO_CAN:
        return f"{cause.strerror} ({BRINGS_ONE})"
    if "interface" in options:
        return str(cause)
    channel = str(getattr(options, "channel", ""))
    interface = "-i socketcan" if channel.startswith(("can", "vcan")) else "--interface"
    return f"{cause} (say {interface} and --channel, or --hub)"


def join_hub(address: HubAddress, name: str, node_ids: Iterable[int] = ()) -> can.BusABC:
    """A bus of a hub, with node ids that nobody else may have there.

    Raises:
        CanError: there is no hub, or it refuses.
    """
    try:
        return HubBus(address, name, node_ids)
    except OSError as failure:
        hint = "start one with `canopen-twin hub`"
        raise can.CanInitializationError(f"no hub at {address}, {hint}: {failure}") from failure
