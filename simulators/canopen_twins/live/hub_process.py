"""A hub in a process of its own, for as long as it is wanted."""

import json
import os
import select
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from threading import Thread
from typing import IO

from canopen_twins.bus.hub.client import is_hub
from canopen_twins.bus.hub.protocol import LOOPBACK, HubAddress
from canopen_twins.errors import UserError

PATIENCE = 10.0  # seconds for it to start, or to end
ANY_PORT = HubAddress(LOOPBACK, 0)
STDERR = 2


Hub = Callable[[], HubAddress]
"""Waits until a hub is there that was being started, and says where.

Raises:
    UserError: it does not start, in its own words.
"""


@contextmanager
def hub_of_run(usual: HubAddress) -> Iterator[Hub]:
    """The hub that is at its usual place, else one of this run that ends with it.

    That is at the usual place, too, where everybody looks for it, or on a free port if some other
    program has that.
    """
    with ExitStack() as stack:
        started = None if is_hub(usual) else stack.enter_context(hub_started(usual))

        def hub() -> HubAddress:
            try:
                return usual if started is None else started()
            except UserError:
                if is_hub(usual):  # of somebody who was a little faster
                    return usual
                return stack.enter_context(hub_process())

        yield hub


@contextmanager
def hub_process(listen: HubAddress = ANY_PORT) -> Iterator[HubAddress]:
    """Where the hub is; it ends with the block, or with this process, whatever ends that.

    Raises:
        UserError: it does not start, in its own words.
    """
    with hub_started(listen) as hub:
        yield hub()


@contextmanager
def hub_started(listen: HubAddress = ANY_PORT) -> Iterator[Hub]:
    """The same, while it starts: there is something else to be done that takes as long."""
    command = [sys.executable, "-P", "-m", "canopen_twins", "hub", "--listen", str(listen)]
    with subprocess.Popen(
        [*command, "--parent", str(os.getpid())],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C is for us: we still have to say goodbye on this bus
    ) as process:
        words = Thread(target=_pass_on, args=(process.stderr,), daemon=True)
        try:
            yield partial(_there, process, listen.host, words)
        finally:
            process.terminate()
            try:
                process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
            if words.is_alive():
                words.join(PATIENCE)


def _there(process: subprocess.Popen[bytes], host: str, words: Thread) -> HubAddress:
    """What it says from then on is passed on."""
    assert process.stdout is not None
    assert process.stderr is not None
    readable, _, _ = select.select([process.stdout], [], [], PATIENCE)
    if not readable or not (told := process.stdout.readline()):
        process.kill()
        said = process.stderr.read().decode(errors="replace").strip()
        raise UserError(said.removeprefix("canopen-twin: ") or "a hub has not started")
    words.start()
    return HubAddress(host, json.loads(told)["port"])


def _pass_on(said: IO[bytes]) -> None:
    """What it says once it is there goes where we say such things."""
    with suppress(OSError, ValueError):  # nobody is there to read it, or it has ended
        for line in said:
            os.write(STDERR, line)
