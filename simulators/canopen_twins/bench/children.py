"""Processes that a master has started and left behind: found, and ended with its run."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER of prctl(2): orphans of our children become ours
GENERATIONS = 10  # of children that come to light when their parents have ended
LONGEST = 60  # characters of a command that are told


@contextmanager
def ended_children(tell: Callable[[str], None]) -> Iterator[None]:
    """Children of this process that begin in the block end with it; `tell` is given their words.

    Elsewhere than on Linux they are left alone: nobody lists them there.
    """
    if sys.platform != "linux":
        yield
        return
    before = _children()
    _adopt(True)
    try:
        yield
    finally:
        told: list[str] = []
        for _ in range(GENERATIONS):
            if not (left := _children() - before):
                break
            told += map(_ended, sorted(left))
        _adopt(False)
        if told := [each for each in told if each]:
            tell(", ".join(dict.fromkeys(told)))


def _children() -> set[int]:
    """Those of every thread."""
    found: set[int] = set()
    for file in Path("/proc/self/task").glob("*/children"):
        with suppress(OSError):  # a thread may be over by now
            found.update(map(int, file.read_text("ascii").split()))
    return found


def _ended(pid: int) -> str:
    """End a child; what it was, empty if it had ended by itself and nobody had asked how."""
    with suppress(OSError):
        process = Path(f"/proc/{pid}")
        is_over = process.joinpath("stat").read_text("utf-8").rpartition(") ")[2].startswith("Z")
        command = (
            process.joinpath("cmdline").read_bytes().replace(b"\0", b" ").decode("utf-8", "replace")
        )
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        return "" if is_over else command.strip()[:LONGEST]
    return ""


def _adopt(wanted: bool) -> None:
    ctypes.CDLL(None).prctl(SUBREAPER, int(wanted), 0, 0, 0)
