"""The hub: serves buses by name over TCP, in one thread.

Its clients are `client.py` and python-can's `socketcand` interface.
"""

import asyncio
import os
from collections.abc import Callable

from simulators.errors import UserError
from simulators.hub.address import Address
from simulators.hub.connection import Connection
from simulators.hub.switch import Switch

NAP = 0.05  # seconds until `stopped` is asked again


def serve_hub(
    address: Address, stopped: Callable[[], bool], ready: Callable[[Address], None]
) -> None:
    """Serve until `stopped` says so; `ready` is told the address, with a free port for port 0.

    Raises:
        UserError: the address cannot be used.
    """
    asyncio.run(_serve(address, stopped, ready))


async def _serve(
    address: Address, stopped: Callable[[], bool], ready: Callable[[Address], None]
) -> None:
    switch = Switch()
    try:
        server = await asyncio.get_running_loop().create_server(
            lambda: Connection(switch), *address
        )
    except OSError as failure:
        raise UserError(f"no hub at {address}: {_words(failure)}") from failure
    ready(Address(address.host, server.sockets[0].getsockname()[1]))
    while not stopped():
        await asyncio.sleep(NAP)
    server.close()
    for client in tuple(switch.clients):
        client.hang_up()


def _words(failure: OSError) -> str:
    """Without what asyncio tells of the address; names that are unknown have no errno."""
    number = failure.errno or 0
    return os.strerror(number) if number > 0 else str(failure.strerror)
