from pathlib import Path

import pytest

from canopen_twins import Bench

VOLTAGE = "Actual voltage"


@pytest.fixture
def probe(tmp_path):
    """A file's twin with a measured INTEGER16 at 0x2009, and TPDOs as the probe has them."""
    text = Path("tests/probe.eds").read_text("ascii")
    head, found, tail = text.partition("[2009]")
    section, _, rest = tail.partition("\n[")
    section = section.replace("DataType=0x0006", "DataType=0x0003").replace(
        "PDOMapping=0", "PDOMapping=1"
    )
    path = tmp_path / "measuring.eds"
    path.write_text(f"{head}{found}{section}\n[{rest}", "ascii")

    def bench(**given):
        bench = Bench(str(path), node_id=5, **given)
        become(bench, 100)
        return bench

    return bench


def become(bench, value):
    bench.node.look()
    bench.node.slave.data_store[0x2009][0] = value.to_bytes(2, "little", signed=True)


def shown(bench):
    (value,) = bench.values("Read only").values()
    return value


def test_a_measured_value_is_as_old_as_its_last_refresh(probe):
    bench = probe(measure_time=0.1)
    assert shown(bench) != 100
    bench.run(0.1)
    assert shown(bench) == 100
    become(bench, 200)
    bench.run(0.09)
    assert shown(bench) == 100
    bench.run(0.01)
    assert shown(bench) == 200


def test_the_master_reads_no_other_value(probe):
    bench = probe(measure_time=0.1)
    bench.run(0.15)
    become(bench, 200)
    assert bench.send("605#4009200000000000") == ["585#4B09200064000000"]
    bench.run(0.05)
    assert bench.send("605#4009200000000000") == ["585#4B092000C8000000"]


def test_in_ideal_it_is_as_it_is(probe):
    assert shown(probe()) == 100


def noisy(bench, samples=200):
    values = []
    for _ in range(samples):
        bench.run(0.02)
        values.append(shown(bench))
    return values


@pytest.mark.parametrize("measure_time", [0.0, 0.02])
def test_noise_is_within_its_digits_and_begins_with_the_seed(probe, measure_time):
    given = {"measure_time": measure_time, "noise": 3}
    values = noisy(probe(**given))
    assert (min(values), max(values)) == (97, 103)
    assert values == noisy(probe(**given))
    assert values != noisy(probe(**given, seed=1))
    assert abs(sum(values) / len(values) - 100) < 0.5


def test_who_looks_changes_nothing(probe):
    watched, left_alone = (probe(measure_time=0.02, noise=3) for _ in range(2))
    for _ in range(100):
        watched.run(0.001)
        shown(watched)
    left_alone.run(0.1)
    assert shown(watched) == shown(left_alone)


def test_noise_stays_in_the_range_of_the_type(probe):
    bench = probe(noise=20)
    become(bench, 0x7FFF)
    values = noisy(bench)
    assert max(values) == 0x7FFF
    assert min(values) > 0x7FFF - 21


def test_what_a_master_writes_is_not_measured():
    bench = Bench("tests/probe.eds", node_id=5, noise=50)
    bench.send("605#2B01200010270000")
    assert bench.values("Word") == {"Word": 10000}


@pytest.mark.parametrize(
    ("device", "settings", "name"),
    [
        ("topcon", {"load": "battery 20 0.1"}, VOLTAGE),
        ("charger", {"load": "bar"}, "Read Actual Values.Read Supply Voltage"),
    ],
)
def test_every_device_has_measured_values(device, settings, name):
    bench = Bench(device, node_id=5, measure_time=0.05, noise=2, **settings)
    values = []
    for _ in range(50):
        bench.run(0.05)
        values += bench.values(name).values()
    assert 2 <= max(values) - min(values) <= 4


def test_a_gateway_tells_the_same_by_tpdo_and_by_sdo():
    bench = Bench("gateway", node_id=5, measure_time=0.1, noise=40)
    bench.run(5.09)
    bench.send("000#0105")
    known = bench.device.system.dictionary.tpdos
    number, pdo = next(each for each in known.items() if each[1].entries[0].index == 0x2001)
    assert number >= 4
    told = []
    for _ in range(50):
        frames = [text for text in bench.run(0.1) if text.startswith(f"{pdo.identifier:03X}#")]
        shown = bench.send(f"605#400120{pdo.entries[0].sub:02X}00000000")[0]
        told += [(text[4:8], shown[12:16]) for text in frames[-1:]]
    assert all(frame == shown for frame, shown in told)
    assert len(set(told)) > 10


def test_a_node_whose_values_are_held_changes_with_their_refreshes_alone(probe):
    bench = probe(measure_time=0.1, noise=1.0)
    clock, before = bench.clock, bench.node.changed_at
    bench.run(0.55)
    assert bench.node.changed_at == before
    become(bench, 200)  # which looks, and so brings the refresh of 0.5 s
    assert bench.node.changed_at == clock.ticks
    bench.run(0.01)
    assert bench.node.changed_at < clock.ticks


def test_a_node_whose_values_have_noise_at_every_moment_changes_all_the_time(probe):
    bench = probe(noise=1.0)
    bench.run(0.55)
    assert bench.node.changed_at == bench.clock.ticks
