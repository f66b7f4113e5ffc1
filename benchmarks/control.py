"""SDO answers while somebody is at the control port: `python -m benchmarks.control [LOAD ...]`.

Master, hub and twin are a process each, and so is who asks at the port, again and again without a
pause. As that takes the machine's time, too, each load is also put on the port of another twin
(`elsewhere`): the difference is what the port itself costs. Rounds of all loads take turns, and of
p50, p99 and maximum of a round the median over the rounds is told: other work on the machine makes
single ones late by tens of milliseconds.
"""

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from http.client import HTTPConnection
from statistics import median

import canopen

from benchmarks import peers
from benchmarks.buses import TWIN, _started
from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.files.shipped import od_file

ROUNDS, READS, PAUSE = 10, 300, 0.0005
PATIENCE = 10.0  # seconds; a busy machine stands still for more than the 0.3 of canopen
HEADERS = {"Content-Type": "application/json"}
LOADS = {
    "state": [("GET", "/nodes/topcon")],
    "values": [("GET", "/nodes/topcon/values")],
    "faults": [("GET", "/nodes/topcon/faults")],
    "objects": [("GET", "/nodes/topcon/objects")],
    "orders": [("POST", "/nodes/topcon/faults/heartbeat_late"), ("DELETE", "/nodes/topcon/faults")],
    "events": [("GET", "/events")],
}


def main(arguments: Sequence[str]) -> None:
    """Measure some loads, or all; `ask HOST:PORT LOAD` is one of them."""
    if arguments[:1] == ["ask"]:
        ask(*arguments[1:])
    parser = argparse.ArgumentParser(prog="control.py", description=__doc__)
    parser.add_argument("load", nargs="*", metavar="LOAD", help=f"of {', '.join(LOADS)}; else all")
    names = parser.parse_args(arguments).load or list(LOADS)
    if unknown := set(names) - LOADS.keys():
        parser.error(f"unknown load {min(unknown)!r}: there is {', '.join(LOADS)}")
    places = [("nobody", ""), *((n, place) for n in names for place in ("elsewhere", "here"))]
    with _bus() as (node, ports):
        rounds = [
            [_round(node, name, ports.get(place)) for name, place in places] for _ in range(ROUNDS)
        ]
    for (name, place), times in zip(places, zip(*rounds, strict=True), strict=True):
        told = (f"{median(each) * 1e3:.2f} ms" for each in zip(*times, strict=True))
        print(f"| {name} {place} | {' | '.join(told)} |", flush=True)


@contextmanager
def _bus() -> Iterator[tuple[canopen.RemoteNode, dict[str, str]]]:
    """A node, and the ports of its twin and of another one."""
    with ExitStack() as stack:
        told = stack.enter_context(_started("hub", "--listen", ":0"))
        address = HubAddress(told["host"], told["port"])
        run = (*TWIN, "--hub", str(address), "--control")
        here = stack.enter_context(_started(*run))["control"]
        elsewhere = stack.enter_context(_started(*run, "-c", "vcan1"))["control"]
        bus = stack.enter_context(HubBus(address, "vcan0"))
        network = stack.enter_context(canopen.Network(bus))
        network.connect()
        path = stack.enter_context(od_file("topcon.eds"))
        node = network.add_node(peers.NODE_ID, str(path))
        node.sdo.RESPONSE_TIMEOUT = PATIENCE
        yield node, {"here": here, "elsewhere": elsewhere}


def _round(node: canopen.RemoteNode, name: str, port: str | None) -> tuple[float, float, float]:
    """Median, 99th percentile and maximum, in seconds."""
    command = [sys.executable, "-m", "benchmarks.control", "ask", str(port), name]
    asking = None if port is None else subprocess.Popen(command, stdout=subprocess.PIPE)
    if asking is not None and asking.stdout is not None:
        asking.stdout.readline()  # it has begun
    times = []
    for _ in range(READS):
        start = time.perf_counter()
        node.sdo.upload(peers.ACTUAL_VOLTAGE, 0)
        times.append(time.perf_counter() - start)
        time.sleep(PAUSE)
    if asking is not None:
        asking.kill()
        asking.communicate()
    times.sort()
    return times[READS // 2], times[READS * 99 // 100], times[-1]


def ask(port: str, name: str) -> None:
    """Ask until somebody ends it."""
    connection = HTTPConnection(port.removeprefix("http://"))
    print("begun", flush=True)
    while True:
        for method, path in LOADS[name]:
            body = json.dumps({}) if method == "POST" else None
            connection.request(method, path, body, HEADERS)
            answer = connection.getresponse()
            assert answer.status == 200
            answer.read()  # of events there is no end


if __name__ == "__main__":
    main(sys.argv[1:])
