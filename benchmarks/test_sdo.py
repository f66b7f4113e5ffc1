"""One expedited upload by `RemoteNode`, from the request to the value."""

from collections.abc import Callable

from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks import peers
from simulators import Bench


def upload(remote) -> Callable[[], bytes]:
    return lambda: remote.sdo.upload(peers.ACTUAL_VOLTAGE, 0)


def test_upload_localnode_virtual(benchmark: BenchmarkFixture):
    with peers.virtual("upload-localnode") as remote:
        assert benchmark(upload(remote)) == bytes(2)


def test_upload_bench(benchmark: BenchmarkFixture):
    remote = Bench("topcon", node_id=peers.NODE_ID).twin.remote
    assert benchmark(upload(remote)) == bytes(2)
