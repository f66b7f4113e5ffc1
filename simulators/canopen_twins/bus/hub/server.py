"""The hub: buses over TCP, where what one client sends all others on its bus get."""

import asyncio
import logging
import os
import socket
from collections.abc import Callable

from canopen_twins.bus.hub.connection import Connection, Switch
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.errors import UserError

log = logging.getLogger(__name__)

NAP = 0.05  # seconds until `stopped` is asked again
WAITING_CLIENTS = 100  # that the system keeps until they are taken
RECOVERY = 0.5  # seconds until clients are taken again that could not be


def serve_hub(
    address: HubAddress, stopped: Callable[[], bool], ready: Callable[[HubAddress], None]
) -> None:
    """Serve until `stopped` says so; `ready` is told the address, with a free port for port 0.

    Raises:
        UserError: the address cannot be used.
    """
    asyncio.run(_serve(address, stopped, ready))


async def _serve(
    address: HubAddress, stopped: Callable[[], bool], ready: Callable[[HubAddress], None]
) -> None:
    switch = Switch()
    try:
        server = await asyncio.get_running_loop().create_server(
            lambda: Connection(switch), *address, start_serving=False
        )
        doors = [each.dup() for each in server.sockets]
        for door in doors:
            door.listen(WAITING_CLIENTS)
    except OSError as failure:
        raise UserError(f"no hub at {address}: {_words(failure)}") from failure
    async with asyncio.TaskGroup() as group:
        keepers = [group.create_task(_take_clients(door, switch)) for door in doors]
        ready(HubAddress(address.host, doors[0].getsockname()[1]))
        while not stopped():
            await asyncio.sleep(NAP)
        for keeper in keepers:
            keeper.cancel()
    server.close()
    for client in tuple(switch.clients):
        client.hang_up()


async def _take_clients(door: socket.socket, switch: Switch) -> None:
    """Let in whoever comes; asyncio's own way tells a hundred times that there is no room."""
    loop = asyncio.get_running_loop()
    door.setblocking(False)
    told = False
    with door:
        while True:
            try:
                connection, _ = await loop.sock_accept(door)
            except OSError as failure:
                if not told:
                    log.warning("nobody is let in at the moment: %s", _words(failure))
                told = True
                await asyncio.sleep(RECOVERY)
            else:
                told = False
                await loop.connect_accepted_socket(lambda: Connection(switch), connection)


def _words(failure: OSError) -> str:
    """Without what asyncio tells of the address; names that are unknown have no errno."""
    number = failure.errno or 0
    return os.strerror(number) if number > 0 else str(failure.strerror)
