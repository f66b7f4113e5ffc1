"""The bus that the command line names: one of python-can, or one on a hub."""

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import can
from can.cli import create_bus_from_namespace

from simulators.errors import UserError
from simulators.hub.address import Address
from simulators.hub.client import HubBus

DEFAULT_BUS = "vcan0"  # on a hub


class Place(NamedTuple):
    """A bus that can be opened, again and again."""

    open: Callable[[], can.BusABC]
    told: Mapping[str, object]
    """What programs are told of it."""


def place(options: argparse.Namespace) -> Place:
    """The bus of the options.

    Raises:
        UserError: they contradict each other.
    """
    interface = getattr(options, "interface", None)
    channel = getattr(options, "channel", None)
    if options.hub is None:
        return Place(partial(_open, options), {"interface": interface, "channel": channel})
    if interface is not None:
        raise UserError("--hub is a bus by itself: leave --interface out")
    address, name = Address.parse(options.hub), channel or DEFAULT_BUS
    return Place(partial(_join, address, name), {"hub": str(address), "channel": name})


def _open(options: argparse.Namespace) -> can.BusABC:
    """What python-can raises says why there is no bus."""
    try:
        return create_bus_from_namespace(options)
    except argparse.ArgumentError as failure:
        hint = "" if "interface" in options else " (which one is said with --interface)"
        raise can.CanInitializationError(f"{failure.__cause__}{hint}") from failure


def _join(address: Address, name: str) -> can.BusABC:
    try:
        return HubBus(address, name)
    except OSError as failure:
        hint = "start one with `canopen-twin hub`"
        raise can.CanInitializationError(f"no hub at {address}, {hint}: {failure}") from failure
