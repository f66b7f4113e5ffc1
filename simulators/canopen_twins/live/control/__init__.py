"""The control port of running twins: HTTP and JSON beside the bus, for any language.

    schema.py   what is said                     view.py       a node as it is, in these words
    app.py      the paths                        guard.py      who may, and how long
    desk.py     from thread to thread            scenarios.py  the one that is played
    events.py   what happens on the bus          stream.py     to whoever watches

Needs the extra `control`. What is asked is done by the thread of the twins (`live.orders`); HTTP is
spoken by a thread of its own.
"""

import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread
from typing import TYPE_CHECKING

from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.live.orders import Orders
from canopen_twins.scenario import Player

if TYPE_CHECKING:
    from uvicorn import Server

    from canopen_twins.live.control.desk import Desk

MOST_CONNECTIONS = 64
LONGEST_HOLD = 0.0005  # seconds for which the port keeps Python from the twins; usually 5 ms


@contextmanager
def control_port(
    segment: Segment[Node],
    orders: Orders,
    address: HubAddress,
    token: str = "",
    player: Player | None = None,
) -> Iterator[HubAddress]:
    """Speaks HTTP at an address until the end, by a thread of its own.

    Args:
        segment: The bus with the nodes.
        orders: Where its thread looks for what it is asked.
        address: Port 0 is a free one.
        token: What every request has to bring; may be empty on this machine only.
        player: That of the run, if it plays a scenario.

    Yields:
        Where it is.

    Raises:
        UserError: FastAPI or uvicorn is missing, nobody may listen there, or a token is missing.
    """
    if not address.is_loopback and not token:
        raise UserError(f"{address} can be reached from other machines: say --control-token TOKEN")
    desk, server = _server(segment, orders, player, token)
    listening = _listen(address)
    thread = Thread(target=server.run, args=([listening],), name="control port")
    with _twins_first(), desk.events.with_notes():
        thread.start()
        try:
            yield HubAddress(*listening.getsockname()[:2])
        finally:
            desk.streams.closing = True
            orders.close()
            server.should_exit = True
            thread.join()
            listening.close()


def _server(
    segment: Segment[Node], orders: Orders, player: Player | None, token: str
) -> "tuple[Desk, Server]":
    try:  # an extra, and half a second
        from uvicorn import Config, Server  # noqa: PLC0415

        from canopen_twins.live.control.app import make_app  # noqa: PLC0415
        from canopen_twins.live.control.desk import Desk  # noqa: PLC0415
        from canopen_twins.live.control.guard import Guard, HurriedProtocol  # noqa: PLC0415
    except ModuleNotFoundError as missing:
        hint = "pip install 'canopen-twins[control]'"
        raise UserError(f"--control needs {missing.name}: {hint}") from missing
    desk = Desk(segment, orders, player)
    config = Config(
        Guard(make_app(desk), token),
        lifespan="off",
        ws="none",
        http=HurriedProtocol,
        loop="asyncio",
        log_config=None,
        access_log=False,
        server_header=False,
        limit_concurrency=MOST_CONNECTIONS,
        timeout_graceful_shutdown=1,
    )
    return desk, Server(config)


@contextmanager
def _twins_first() -> Iterator[None]:
    """The twins have Python back soon after they want it."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(LONGEST_HOLD)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def _listen(address: HubAddress) -> socket.socket:
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    try:
        return socket.create_server(tuple(address), family=family)
    except OSError as failure:
        reason = str(failure.strerror).partition(" (")[0]  # it says once more where
        raise UserError(f"the control port cannot listen on {address}: {reason}") from failure
