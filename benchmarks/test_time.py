"""Simulated time: how long an hour takes, of an output that rests and of one that is kept busy."""

from collections.abc import Callable

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from canopen_twins import Bench

LEVELS = (1000, 3000)  # parts


def powered(load: str) -> Bench:
    """A TopCon with its output on, 200 V, and a heartbeat every second."""
    bench = Bench("topcon", node_id=5, load=load)
    bench.master.nmt.state = "OPERATIONAL"
    for index, value in ((0x1017, 1000), (0x2010, 2000), (0x2011, 4000), (0x2014, 1)):
        bench.sdo[index].raw = value
    bench.run(10.0)
    assert bench.device.stage.running
    assert bench.device.stage.current > 0
    return bench


def test_settled_hour(benchmark: BenchmarkFixture):
    bench = powered("resistor 4")
    benchmark.pedantic(bench.run, args=(3600.0,), rounds=7, warmup_rounds=1)
    assert bench.trace[-1].frame.can_id == 0x705


def test_questions(benchmark: BenchmarkFixture):
    """A master that asks a settled output for its voltage every 10 ms."""
    bench = powered("resistor 4")

    def ten_seconds() -> None:
        for _ in range(1000):
            bench.sdo.upload(0x2020, 0)
            bench.run(0.01)

    benchmark.pedantic(ten_seconds, rounds=5, warmup_rounds=1)
    assert bench.device.rest


@pytest.mark.parametrize("load", ["resistor 4", "inductor 4 0.1"])
def test_set_values(benchmark: BenchmarkFixture, load: str):
    """A new set value every 100 ms: a ramp, a transient, rest."""
    bench = powered(load)
    benchmark.pedantic(set_values(bench), rounds=5, warmup_rounds=1)
    assert not bench.device.stage.errors


def set_values(bench: Bench) -> Callable[[], None]:
    def ten_seconds() -> None:
        for change in range(100):
            bench.sdo[0x2010].raw = LEVELS[change % 2]
            bench.run(0.1)

    return ten_seconds


def test_control_loop(benchmark: BenchmarkFixture):
    """RPDO 1 with new set values, SYNC and TPDO 1 every 10 ms: it never comes to rest."""
    bench = powered("inductor 4 0.1")
    bench.sdo[0x1800][2].raw = 1
    frames = [f"205#{level.to_bytes(2, 'little').hex()}" for level in LEVELS]

    def ten_seconds() -> None:
        for cycle in range(1000):
            bench.send(frames[cycle % 2])
            assert len(bench.send("080#")) == 1
            bench.run(0.01)

    benchmark.pedantic(ten_seconds, rounds=5, warmup_rounds=1)
    assert bench.device.stage.running


def test_calibration(benchmark: BenchmarkFixture):
    """Twenty minutes of high voltage, a set of TPDOs every 500 ms and a heartbeat every second."""

    def calibrating() -> tuple[tuple[Bench], dict[str, object]]:
        bench = Bench("charger")
        parameters = bench.sdo[0x2002]
        parameters[0x02].raw, parameters[0x08].raw, parameters[0x19].raw = 8, 20_000, 2
        bench.master.nmt.state = "OPERATIONAL"
        bench.send("263#0F")
        return (bench,), {}

    def calibrate(bench: Bench) -> None:
        bench.run(20 * 60.0)
        assert bench.sdo[0x2002][0x1A].raw == 10_000_000

    benchmark.pedantic(calibrate, setup=calibrating, rounds=7)


def test_governing(benchmark: BenchmarkFixture):
    """Twenty minutes in Operational: all cyclic TPDOs, an engine at its setpoint, a heartbeat."""

    def operational() -> tuple[tuple[Bench], dict[str, object]]:
        bench = Bench("gateway", run=True, autostart=True)
        bench.run(0.5)
        bench.master.nmt.state = "OPERATIONAL"
        return (bench,), {}

    def govern(bench: Bench) -> None:
        bench.run(20 * 60.0)
        assert len(bench.trace) > 90_000

    benchmark.pedantic(govern, setup=operational, rounds=2)
