"""Round trips over every kind of bus: `python -m benchmarks.buses BUS...` prints a line for each.

An SDO upload by canopen's `RemoteNode`, from the request to the value; master and TopCon are two
processes, except on `virtual`. What `udp_multicast` and `vcan0` need is told in
docs/reference/buses.md.
"""

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from statistics import median, quantiles
from typing import Any

import canopen

from benchmarks import peers
from benchmarks.test_sdo import served
from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.files.shipped import od_file

ROUNDS, READS = 5, 2000
GROUP = "239.74.163.2"
COMMAND = (sys.executable, "-m", "canopen_twins")
TWIN = ("run", "topcon", "-n", str(peers.NODE_ID), "--set", "timing=ideal")


def main(names: Sequence[str]) -> None:
    """Measure the buses of these names, or all."""
    for name in names or BUSES:
        with BUSES[name]() as network, od_file("topcon.eds") as path:
            node = network.add_node(peers.NODE_ID, str(path))
            rounds = [_round(node) for _ in range(ROUNDS)]
        middle = median(median(times) for times in rounds)
        late = median(quantiles(times, n=100)[98] for times in rounds)
        print(f"| {name} | {middle * 1e3:.2f} ms | {late * 1e3:.2f} ms |", flush=True)


def _round(node: canopen.RemoteNode) -> list[float]:
    times = []
    for _ in range(READS):
        start = time.perf_counter()
        node.sdo.upload(peers.ACTUAL_VOLTAGE, 0)
        times.append(time.perf_counter() - start)
    return times


@contextmanager
def _started(*arguments: str) -> Iterator[dict[str, Any]]:
    with subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        try:
            yield json.loads(process.stdout.readline())
        finally:
            process.terminate()


@contextmanager
def _connected(**bus: Any) -> Iterator[canopen.Network]:
    with canopen.Network().connect(**bus) as network:
        yield network


@contextmanager
def virtual() -> Iterator[canopen.Network]:
    """Two threads of one process."""
    with served("buses"), _connected(interface="virtual", channel="buses") as network:
        yield network


@contextmanager
def _hub() -> Iterator[HubAddress]:
    with ExitStack() as stack:
        told = stack.enter_context(_started("hub", "--listen", ":0"))
        address = HubAddress(told["host"], told["port"])
        stack.enter_context(_started(*TWIN, "--hub", str(address)))
        yield address


@contextmanager
def hub(tcp_tune: bool = True) -> Iterator[canopen.Network]:
    """Three processes, the master with python-can's own client."""
    with _hub() as address:
        bus = {"interface": "socketcand", "channel": "vcan0", "tcp_tune": tcp_tune}
        with _connected(**bus, host=address.host, port=address.port) as network:
            yield network


@contextmanager
def hub_by_our_client() -> Iterator[canopen.Network]:
    """The same, the master with the client of the twins."""
    with _hub() as address, HubBus(address, "vcan0") as bus, canopen.Network(bus) as network:
        network.connect()
        yield network


@contextmanager
def udp_multicast() -> Iterator[canopen.Network]:
    """Two processes, no server."""
    with (
        _started(*TWIN, "-i", "udp_multicast", "-c", GROUP),
        _connected(interface="udp_multicast", channel=GROUP) as network,
    ):
        yield network


@contextmanager
def vcan0() -> Iterator[canopen.Network]:
    """Two processes and a kernel."""
    with (
        _started(*TWIN, "-i", "socketcan", "-c", "vcan0"),
        _connected(interface="socketcan", channel="vcan0") as network,
    ):
        yield network


BUSES = {
    "virtual": virtual,
    "hub": hub,
    "hub-untuned": lambda: hub(tcp_tune=False),
    "hub-our-client": hub_by_our_client,
    "udp_multicast": udp_multicast,
    "vcan0": vcan0,
}

if __name__ == "__main__":
    main(sys.argv[1:])
