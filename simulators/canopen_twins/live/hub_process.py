"""A hub in a process of its own, on a free port of this machine, for as long as it is wanted."""

import json
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from canopen_twins.bus.hub.protocol import LOOPBACK, HubAddress

PATIENCE = 10.0  # seconds for it to start, or to end


@contextmanager
def hub_process() -> Iterator[HubAddress]:
    """Where the hub is; it ends with the block, or with this process, whatever ends that.

    Raises:
        RuntimeError: it does not start.
    """
    command = [sys.executable, "-P", "-m", "canopen_twins", "hub", "--listen", f"{LOOPBACK}:0"]
    with subprocess.Popen(
        [*command, "--parent", str(os.getpid())],
        stdout=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C is for us: we still have to say goodbye on this bus
    ) as process:
        try:
            assert process.stdout is not None
            readable, _, _ = select.select([process.stdout], [], [], PATIENCE)
            if not readable or not (told := process.stdout.readline()):
                raise RuntimeError("the hub of this run has not started")
            yield HubAddress(LOOPBACK, json.loads(told)["port"])
        finally:
            process.terminate()
            try:
                process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
