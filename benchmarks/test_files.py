"""A file that describes a device: reading it, and a bus full of its twins."""

import resource
from collections.abc import Callable
from pathlib import Path

import canopen
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.peers import FAN
from canopen_twins import Bench
from canopen_twins.slave.eds.reader import read_eds

ENTRIES = 1000
MOST_MEMORY = 300 * 1024  # KiB
OBJECT = """[{index:04X}]
ParameterName=Object {index}
ObjectType=0x7
DataType=0x0006
AccessType=rw
DefaultValue={index}
LowLimit=0
HighLimit=60000
PDOMapping=1
"""
READERS: dict[str, Callable[[Path], object]] = {
    "reader": read_eds,
    "import_od": lambda path: canopen.import_od(str(path)),
}


@pytest.mark.parametrize("reader", READERS)
def test_read(benchmark: BenchmarkFixture, tmp_path: Path, reader: str):
    path = tmp_path / "large.eds"
    objects = "".join(OBJECT.format(index=0x3000 + each) for each in range(ENTRIES))
    path.write_text(FAN.read_text("ascii") + "\n" + objects)
    benchmark(READERS[reader], path)


def test_many(benchmark: BenchmarkFixture):
    """127 twins, from the first to the last frame of a minute."""

    def minute() -> None:
        bench = Bench.of({f"node {node_id}": (FAN, node_id) for node_id in range(1, 128)})
        for node_id in range(1, 128):
            bench.send(f"{0x600 + node_id:03X}#2B171000E8030000")  # heartbeat every second
        bench.send("000#0100")  # NMT: start
        sent = sum(len(bench.run(0.1)) + len(bench.send("080#")) for _ in range(600))
        assert sent == 127 * (600 + 60)

    benchmark.pedantic(minute, rounds=3)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < MOST_MEMORY
