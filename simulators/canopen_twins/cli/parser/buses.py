"""The commands that run twins on a bus, or bring one."""

import argparse
from pathlib import Path

from canopen_twins.cli.parser.arguments import DEVICE, SCENARIO, device, kept, reports
from canopen_twins.cli.parser.command import Commands, add

HUB = "127.0.0.1:29536"


def add_run(commands: Commands) -> None:
    """run."""
    text = "run twins on a CAN bus in real time, until they are stopped or a scenario is over"
    parser = add(commands, "run", text, "run")
    device(parser, f"{DEVICE}, or a bench file; with --scenario it may be left out", nargs="?")
    parser.add_argument("--scenario", metavar="SCENARIO", help=SCENARIO)
    parser.add_argument(
        "--nvram", type=Path, metavar="FILE", help="keep what the device stores in a file"
    )
    text = f"join a hub (default: {HUB}); the bus is that of -c"
    parser.add_argument("--hub", nargs="?", const="", metavar="HOST:PORT", help=text)
    parser.add_argument(
        "--real-bus", action="store_true", help="the bus may have real devices on it"
    )
    reports(parser)
    kept(parser)
    parser.late = _bus


def _bus(parser: argparse.ArgumentParser) -> None:
    from can.cli import add_bus_arguments  # noqa: PLC0415

    add_bus_arguments(parser)


def add_hub(commands: Commands) -> None:
    """hub."""
    text = "run a hub: buses that every process of this machine can join, with no vcan and no root"
    parser = add(commands, "hub", text, "hub")
    text = f"where (default: {HUB})"
    parser.add_argument("--listen", default="", metavar="HOST:PORT", help=text)


def add_vcan(commands: Commands) -> None:
    """vcan."""
    text = "run a command where there is a real vcan0: here, or in a user-mode Linux guest"
    parser = add(commands, "vcan", text, "vcan")
    parser.add_argument(
        "--limit", type=float, default=300.0, metavar="SECONDS", help="end it after this time (300)"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="keep what is written there; the rest is lost"
    )
    parser.add_argument("words", nargs="+", metavar="COMMAND", help="after --, with its arguments")
