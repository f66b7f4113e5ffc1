"""What a master in C measures on vcan0: `canopen-twin vcan -- python -m benchmarks.c_master`.

Prints a line for every device and thing it does, beside canopen's `LocalNode`: median and 99th
percentile in microseconds, how many in a second, and the ratio of that to an upload of `LocalNode`
in the round before. The master is `c_master.c`, which needs a C compiler.
"""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import can

from benchmarks import peers
from benchmarks.buses import COMMAND
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import message_of

SOURCE = Path(__file__).with_suffix(".c")
CHANNEL = ("-i", "socketcan", "-c", "vcan0")
LOCAL_NODE = """
from time import sleep
import canopen
from benchmarks import peers
network = canopen.Network().connect(interface="socketcan", channel="vcan0")
network.add_node(peers.local_node())
print("ready", flush=True)
sleep(3600)
"""
ROUNDS, WARM_UP = 3, 100
ID = f"{peers.NODE_ID:02X}"


class Act(NamedTuple):
    """What the master does again and again, and what it waits for."""

    request: str
    awaited: str
    count: int = 2000
    pause: int = 0
    """Microseconds before each."""


UPLOAD = Act(f"6{ID}#4017100000000000", f"5{0x80 + peers.NODE_ID:02X}")
SYNC = Act("080#", f"1{0x80 + peers.NODE_ID:02X}")
RESET = Act(f"000#81{ID}", f"7{ID}", count=50, pause=20_000)
TPDO1_ON_EVERY_SYNC, OPERATIONAL = f"6{ID}#2F00180201000000", f"000#01{ID}"
DEVICES = {
    "topcon": {"upload": UPLOAD, "SYNC": SYNC, "reset": RESET},
    "charger": {"upload": UPLOAD, "reset": RESET},
    "gateway": {"upload": UPLOAD, "reset": RESET},
}


class Times(NamedTuple):
    """In microseconds, and how many in a second."""

    median: int
    late: int
    rate: int


def main() -> None:
    """Measure everything some times, one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        master = Path(folder) / "c_master"
        subprocess.run(["cc", "-O2", "-o", master, SOURCE], check=True)
        print("| | | median | 99 % | in a second | against LocalNode |")
        for _ in range(ROUNDS):
            with _started(sys.executable, "-c", LOCAL_NODE):
                peer = _measured(master, UPLOAD)
            _tell("LocalNode", "upload", peer, peer)
            for device in DEVICES:
                _measure(master, device, peer)


def _measure(master: Path, device: str, peer: Times) -> None:
    twin = ("run", device, "-n", str(peers.NODE_ID), "--set", "timing=ideal", *CHANNEL)
    with _started(*COMMAND, *twin):
        _send(TPDO1_ON_EVERY_SYNC, OPERATIONAL)  # the other two refuse the first
        for name, act in DEVICES[device].items():
            _tell(device, name, _measured(master, act), peer)


def _measured(master: Path, act: Act) -> Times:
    _do(master, act._replace(count=min(act.count, WARM_UP)))
    return _do(master, act)


def _do(master: Path, act: Act) -> Times:
    command = [master, act.request, act.awaited, str(act.count), str(act.pause)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return Times(*map(int, told.split()))


def _send(*frames: str) -> None:
    """Send frames when the node has booted, which takes a gateway its time."""
    with can.Bus(interface="socketcan", channel="vcan0") as bus:
        messages = [message_of(Frame.parse(frame)) for frame in (UPLOAD.request, *frames)]
        answer = None
        while answer is None or answer.arbitration_id != int(UPLOAD.awaited, 16):
            bus.send(messages[0])
            answer = bus.recv(0.5)
        for message in messages[1:]:
            bus.send(message)


def _tell(who: str, what: str, times: Times, peer: Times) -> None:
    ratio = times.rate / peer.rate
    print(f"| {who} | {what} | {times.median} | {times.late} | {times.rate} | {ratio:.2f} |")


@contextmanager
def _started(*command: str) -> Iterator[None]:
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        process.stdout.readline()  # it is on the bus
        try:
            yield
        finally:
            process.terminate()


if __name__ == "__main__":
    main()
