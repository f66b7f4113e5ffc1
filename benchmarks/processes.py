"""Processes that are watched while they are loaded: what they take of memory and of a core."""

import json
import os
import re
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import quantiles
from typing import Any, NamedTuple

PATIENCE = 30.0  # seconds to start, and to end
TICKS = os.sysconf("SC_CLK_TCK")


class Watched:
    """A command of ours in a process of its own; at the end it is told to stop."""

    def __init__(self, *arguments: str, python: str = sys.executable) -> None:
        command = [python, "-m", "canopen_twins", *arguments]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout
        line = self.process.stdout.readline()
        self.told: Mapping[str, Any] = json.loads(line) if line else {}
        self.said: list[str] = []
        """What people are told, line by line."""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stderr
        self.said.extend(self.process.stderr)

    @property
    def memory(self) -> float:
        """What it has in memory, in MB."""
        for line in self._of("status").splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024
        return 0.0

    @property
    def seconds(self) -> float:
        """What it has taken of a core so far."""
        user, system = self._of("stat").rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / TICKS

    def _of(self, name: str) -> str:
        return Path(f"/proc/{self.process.pid}/{name}").read_text("utf-8")

    def end(self) -> int:
        """Its exit code."""
        self.process.terminate()
        code = self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        return code


@contextmanager
def watched(*arguments: str, python: str = sys.executable) -> Iterator[Watched]:
    """One that is gone at the end, whatever comes."""
    process = Watched(*arguments, python=python)
    try:
        yield process
    finally:
        if process.process.poll() is None:
            process.process.kill()
        process.process.wait()
        for stream in (process.process.stdout, process.process.stderr):
            assert stream
            stream.close()


class Sample(NamedTuple):
    """What a process had at a moment."""

    time: float
    """Seconds."""
    memory: float
    """MB."""


def slope(samples: Sequence[Sample]) -> float:
    """By how many MB an hour memory grows, after the first half of the time."""
    later = samples[len(samples) // 2 :]
    if len(later) < 2:
        return 0.0
    times, sizes = [each.time for each in later], [each.memory for each in later]
    middle, mean = sum(times) / len(times), sum(sizes) / len(sizes)
    spread = sum((time - middle) ** 2 for time in times)
    rise = sum((t - middle) * (s - mean) for t, s in zip(times, sizes, strict=True))
    return 3600 * rise / spread if spread else 0.0


def percentiles(times: Sequence[float]) -> str:
    """In ms: the median, the 99th and 99.9th percentile, and the worst."""
    if len(times) < 2:
        return "too few"
    cut = quantiles(times, n=1000)
    told = {"p50": cut[499], "p99": cut[989], "p99.9": cut[998], "worst": max(times)}
    return ", ".join(f"{name} {1e3 * time:.1f} ms" for name, time in told.items())


def judged(broken: Sequence[str]) -> int:
    """Say which invariants do not hold; an exit code."""
    alike = Counter(re.sub(r"\d+(\.\d+)?", "N", each) for each in broken)
    for each in broken:
        if times := alike.pop(re.sub(r"\d+(\.\d+)?", "N", each), 0):
            print(f"BROKEN: {each}" + (f" (and {times - 1} alike)" if times > 1 else ""))
    print("every invariant holds" if not broken else f"{len(broken)} broken")
    return int(bool(broken))
