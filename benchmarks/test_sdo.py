"""One expedited upload by `RemoteNode`, from the request to the value."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

import can
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks import peers
from canopen_twins import Bench, devices
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.live.serve import serve

OBJECTS = {"memory": 0x1017, "measured": 0x2020}
"""Heartbeat time, in memory on both sides; actual voltage, which the twin has from its model."""

objects = pytest.mark.parametrize("name", OBJECTS)


def upload(remote, name: str) -> Callable[[], bytes]:
    return lambda: remote.sdo.upload(OBJECTS[name], 0)


@contextmanager
def served(channel: str, device: str = "topcon") -> Iterator[None]:
    """A twin on a `virtual` bus, in a thread of its own."""
    segment = Segment()
    connect(segment, devices.create(device, node_id=peers.NODE_ID), device).power_on()
    ready, stop = Event(), Event()

    def run() -> None:
        serve(
            segment,
            lambda: can.Bus(interface="virtual", channel=channel),
            stop.is_set,
            ready.set,
        )

    thread = Thread(target=run)
    thread.start()
    ready.wait()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@objects
def test_upload_localnode_virtual(benchmark: BenchmarkFixture, name: str):
    with peers.virtual(f"localnode-{name}") as remote:
        assert benchmark(upload(remote, name)) == bytes(2)


@objects
def test_upload_served_virtual(benchmark: BenchmarkFixture, name: str):
    channel = f"served-{name}"
    with served(channel), peers.master(channel) as remote:
        assert benchmark(upload(remote, name)) == bytes(2)


@objects
def test_upload_bench(benchmark: BenchmarkFixture, name: str):
    remote = Bench("topcon", node_id=peers.NODE_ID).twin.remote
    assert benchmark(upload(remote, name)) == bytes(2)


def test_upload_file_localnode(benchmark: BenchmarkFixture):
    """The same with the EDS of the fan, of which there is no device but the file."""
    with peers.virtual("localnode-file", peers.FAN) as remote:
        assert benchmark(lambda: remote.sdo.upload(0x1017, 0)) == bytes(2)


def test_upload_file_twin(benchmark: BenchmarkFixture):
    channel = "served-file"
    with served(channel, str(peers.FAN)), peers.master(channel, peers.FAN) as remote:
        assert benchmark(lambda: remote.sdo.upload(0x1017, 0)) == bytes(2)
