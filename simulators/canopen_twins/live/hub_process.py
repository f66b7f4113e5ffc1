"""A hub in a process of its own, for as long as it is wanted."""

import json
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from threading import Thread
from typing import IO

from canopen_twins.bus.hub.client import is_hub
from canopen_twins.bus.hub.protocol import LOOPBACK, HubAddress
from canopen_twins.errors import UserError

PATIENCE = 10.0  # seconds for it to start, or to end
ANY_PORT = HubAddress(LOOPBACK, 0)
STDERR = 2


@contextmanager
def hub_of_run(usual: HubAddress) -> Iterator[HubAddress]:
    """Where the hub is that is at its usual place, else one of this run that ends with it.

    That is at the usual place, too, where everybody looks for it, or on a free port if some other
    program has that.

    Raises:
        UserError: as `hub_process`.
    """
    with ExitStack() as stack:
        address = usual
        if not is_hub(usual):
            try:
                stack.enter_context(hub_process(usual))
            except UserError:
                if not is_hub(usual):  # no hub of somebody who was a little faster
                    address = stack.enter_context(hub_process())
        yield address


@contextmanager
def hub_process(listen: HubAddress = ANY_PORT) -> Iterator[HubAddress]:
    """Where the hub is; it ends with the block, or with this process, whatever ends that.

    Raises:
        UserError: it does not start, in its own words.
    """
    command = [sys.executable, "-P", "-m", "canopen_twins", "hub", "--listen", str(listen)]
    with subprocess.Popen(
        [*command, "--parent", str(os.getpid())],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C is for us: we still have to say goodbye on this bus
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        words = Thread(target=_pass_on, args=(process.stderr,), daemon=True)
        try:
            readable, _, _ = select.select([process.stdout], [], [], PATIENCE)
            if not readable or not (told := process.stdout.readline()):
                process.kill()
                said = process.stderr.read().decode(errors="replace").strip()
                raise UserError(said.removeprefix("canopen-twin: ") or "a hub has not started")
            words.start()
            yield HubAddress(listen.host, json.loads(told)["port"])
        finally:
            process.terminate()
            try:
                process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
            if words.is_alive():
                words.join(PATIENCE)


def _pass_on(said: IO[bytes]) -> None:
    """What it says once it is there goes where we say such things."""
    with suppress(OSError, ValueError):  # nobody is there to read it, or it has ended
        for line in said:
            os.write(STDERR, line)
