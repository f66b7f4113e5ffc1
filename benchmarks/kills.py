"""kill -9 while storing: `python -m benchmarks.kills --kills 1000`.

A process has a charger whose memory is a file; it writes one number after the other to an object,
stores it by 1010h and says so, until it is killed at a moment that chance has chosen.

Invariants: the file can be read each time, nothing that was acknowledged is missing, nothing is
called damaged, and what a killed process leaves beside it is at most one part.
"""

import argparse
import os
import signal
import sys
import tempfile
import time
from pathlib import Path
from random import Random

from benchmarks.processes import judged
from canopen_twins import Bench
from canopen_twins.device.device import Device
from canopen_twins.devices import find
from canopen_twins.files.whole import PART
from canopen_twins.slave.memory import Memory

HEARTBEAT_TIME = 0x1017
LONGEST = 0.05  # seconds until it is killed
STEP = 100  # ms, in which the object counts
LOWEST, HIGHEST = 10, 600  # in these steps


def main() -> int:
    """1 if an invariant does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chance, broken, stored, parts = Random(options.seed), [], LOWEST, 0
    told = 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "memory.json"
        for kill in range(options.kills):
            said = _killed(file, stored + 1, chance.uniform(0.0, LONGEST))
            acknowledged = max([stored, *said])
            told += len(said)
            stored = _value(file)
            if not acknowledged <= stored <= acknowledged + 1:
                broken.append(f"kill {kill}: {stored} is kept, {acknowledged} was acknowledged")
            if stored >= HIGHEST - 1:
                file.unlink()
                stored = LOWEST
            parts += sum(1 for each in Path(folder).glob(f".*{PART}") if not each.unlink())
        others = [path.name for path in Path(folder).iterdir() if path != file]
    broken += [f"{name} is left" for name in others]
    if parts > options.kills:
        broken.append(f"{parts} parts are left")
    print(f"{options.kills} kills, {told} values stored, {parts} kills in a write")
    return judged(broken)


def _charger(file: Path) -> Bench:
    device: Device = find("charger")(node_id=5)
    device.memory = Memory(file)
    return Bench.of({"charger": device})


def _value(file: Path) -> int:
    """What a charger has after its boot; the time of a factory is none of ours."""
    if not file.exists():
        return LOWEST
    return int(_charger(file)["charger"].sdo[HEARTBEAT_TIME].raw) // STEP


def _killed(file: Path, first: int, after: float) -> list[int]:
    """Let a process store from a number on, kill it: what it has said it has stored."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reader)
            _store(file, first, writer)
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as said:
        said.readline()
        time.sleep(after)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return [int(line) for line in said if line.endswith("\n")]


def _store(file: Path, first: int, writer: int) -> None:
    charger = _charger(file)["charger"]
    os.write(writer, b"ready\n")
    for number in range(first, HIGHEST):
        charger.sdo[HEARTBEAT_TIME].raw = number * STEP
        charger.sdo.download(0x1010, 1, b"save")
        os.write(writer, f"{number}\n".encode())


if __name__ == "__main__":
    sys.exit(main())
