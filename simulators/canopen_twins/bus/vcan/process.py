"""A process with a time limit, its output passed on while it runs; nothing of it is left behind."""

import ctypes
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, BinaryIO, cast

TIME_IS_UP = 124  # as timeout(1) has it


def run(command: Sequence[str], limit: float) -> int:
    """Run a command here and return its exit status as a shell has it."""
    try:
        with group(command) as started:
            status = started.wait(limit)
    except FileNotFoundError:
        print(f"{command[0]}: not found", file=sys.stderr)
        return 127
    except subprocess.TimeoutExpired:
        return out_of_time(limit)
    return status if status >= 0 else 128 - status


@contextmanager
def group(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[bytes]]:
    """A process in a group of its own; the whole group ends with the block, also on SIGTERM."""
    before = signal.signal(signal.SIGTERM, _leave)
    try:
        with subprocess.Popen(command, start_new_session=True, **options) as started:
            try:
                yield started
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(started.pid, signal.SIGKILL)
    finally:
        signal.signal(signal.SIGTERM, before)


def relay(started: subprocess.Popen[bytes], limit: float) -> bool:
    """Pass on what a process says until it has ended; false if that takes too long."""
    end = time.monotonic() + limit
    with selectors.DefaultSelector() as selector:
        for pipe, sink in ((started.stdout, sys.stdout), (started.stderr, sys.stderr)):
            selector.register(cast(BinaryIO, pipe), selectors.EVENT_READ, sink.buffer)
        while selector.get_map():
            ready = selector.select(max(end - time.monotonic(), 0))
            if not ready:
                return False
            for key, _ in ready:
                _pass_on(selector, key)
    return True


def _pass_on(selector: selectors.BaseSelector, key: selectors.SelectorKey) -> None:
    if chunk := os.read(key.fd, 1 << 16):
        key.data.write(chunk)
        key.data.flush()
    else:
        selector.unregister(key.fileobj)


def control(operation: int, *arguments: int | bytes) -> None:
    """prctl(2) for this process.

    Raises:
        OSError: the kernel refuses.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    rest = (0,) * (4 - len(arguments))
    if libc.prctl(operation, *arguments, *rest):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def out_of_time(limit: float) -> int:
    """Say that the limit was too short."""
    print(f"stopped after {limit:g} s", file=sys.stderr)
    return TIME_IS_UP


def _leave(number: int, frame: FrameType | None) -> None:
    sys.exit(128 + number)
