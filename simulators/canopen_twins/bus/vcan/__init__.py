"""A command on a real vcan0: on this host if it has one, otherwise in a user-mode Linux guest."""

import socket
from collections.abc import Sequence
from pathlib import Path

from canopen_twins.bus.vcan import guest, process

INTERFACE = "vcan0"
IS_UP = 1  # IFF_UP of the interface's flags


def is_up() -> bool:
    """Whether this host has CAN sockets and a vcan0 that is up."""
    flags = Path("/sys/class/net", INTERFACE, "flags")
    if not hasattr(socket, "AF_CAN") or not flags.exists():
        return False
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return False
    return bool(int(flags.read_text("ascii"), 16) & IS_UP)


def run(command: Sequence[str], limit: float, out: Path | None = None) -> int:
    """Run a command and return its exit status, 124 if it takes longer than `limit` seconds.

    Nothing it writes to files is left afterwards but what is in the folder `out`; on a host with
    a vcan0 of its own everything is.

    Raises:
        UserError: there is no vcan0, and something that a guest needs is missing.
    """
    if is_up():
        return process.run(command, limit)
    return guest.run(command, limit, out)
