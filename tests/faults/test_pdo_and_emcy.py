import pytest

from canopen_twins import Bench, UserError

from .conftest import SYNC

ZEROS, AT_200_V = "185#0000000000000000", "185#D007000000000300"
OVERVOLTAGE, NO_ERROR = "085#0023032300000000", "085#0000000000000000"


def to_200_volt(bench):
    bench.sdo["Voltage reference"].raw = bench.sdo["Current reference"].raw = 2000
    bench.sdo["Run command"].raw = 1
    bench.run(1.0)


def test_a_tpdo_is_frozen(topcon):
    topcon.inject("pdo_frozen", number=1)
    assert topcon.send(SYNC) == [ZEROS]
    to_200_volt(topcon)
    assert topcon.send(SYNC) == [ZEROS]
    topcon.clear()
    assert topcon.send(SYNC) == [AT_200_V]


def test_each_frozen_tpdo_keeps_its_own_identifier_and_data():
    bench = Bench("charger", node_id=99)
    at_start = bench.send("000#0163")
    assert [frame[:3] for frame in at_start] == ["1E3", "2E3", "3E3"]
    bench.inject("pdo_frozen")
    assert [frame for frame in bench.run(0.6) if not frame.startswith("763")] == at_start


def test_every_other_tpdo_is_missing(topcon):
    assert topcon.send(SYNC) == [ZEROS]
    topcon.inject("pdo_missing", number=2)
    assert topcon.send(SYNC) == [ZEROS]
    topcon.inject("pdo_missing", times=1)
    assert [topcon.send(SYNC), topcon.send(SYNC)] == [[], [ZEROS]]


def test_a_tpdo_is_short(topcon):
    topcon.inject("pdo_short", missing=6)
    assert topcon.send(SYNC) == ["185#0000"]
    topcon.inject("pdo_short")
    assert topcon.send("185#R") == [ZEROS[:-2]]


def test_a_tpdo_has_another_identifier(topcon):
    topcon.inject("pdo_wrong_cob_id", cob_id=0x186)
    assert topcon.send(SYNC) == ["186#0000000000000000"]


def test_a_tpdo_is_found_by_the_identifier_it_has_at_the_moment(topcon):
    topcon.sdo[0x1800][1].raw = 0x80000185
    topcon.sdo[0x1800][1].raw = 0x1A5
    assert [frame[:4] for frame in topcon.send(SYNC)] == ["1A5#"]
    topcon.inject("pdo_missing", number=1)
    assert topcon.send(SYNC) == []


def test_a_tpdo_jitters_and_none_overtakes_another(topcon):
    topcon.inject("pdo_jitter", seconds=0.02)
    start = topcon.clock.now
    for _ in range(50):
        topcon.send(SYNC)
        topcon.run(0.01)
    topcon.run(0.02)
    times = [record.time - start for record in topcon.trace if record.frame.can_id == 0x185][-50:]
    delays = [time - n * 0.01 for n, time in enumerate(times)]
    assert len(times) == 50
    assert times == sorted(times)
    assert all(-1e-9 <= delay <= 0.02 for delay in delays)
    assert len({round(delay, 6) for delay in delays}) > 25


def test_a_tpdo_that_the_device_does_not_have_is_refused(topcon):
    with pytest.raises(UserError, match="the device has no TPDO 9"):
        topcon.inject("pdo_missing", number=9)


def test_an_emergency_is_told_again_and_again(topcon, active):
    topcon.inject("emcy_storm", code=0x5000, register=0x11, detail=0x1234, seconds=0.01, times=5)
    assert active() == ["emcy_storm"]
    sent = topcon.run(1.0)
    assert topcon.sent.count("085#0050113412000000") == 5
    assert sent.count("085#0050113412000000") == 4  # the first came at once
    assert active() == []


def test_a_storm_is_over_when_it_is_cleared_and_waits_while_the_node_is_stopped(topcon):
    topcon.inject("emcy_storm", seconds=0.01)
    assert topcon.run(0.03).count("085#0010010000000000") == 3
    topcon.send("000#0205")
    assert "085" not in str(topcon.run(0.1))
    topcon.send("000#0105")
    assert "085#0010010000000000" in topcon.run(0.01)
    topcon.clear()
    assert "085" not in str(topcon.run(1.0))


def test_an_emergency_is_lost_the_registers_have_it(topcon):
    topcon.inject("emcy_lost", times=1)
    topcon.inject("error", number=0x23)
    assert OVERVOLTAGE not in topcon.sent
    assert topcon.sdo["Error Register"].raw == 3
    topcon.sdo["Run command"].raw = 2
    assert NO_ERROR in topcon.sent


def test_an_emergency_is_told_twice(topcon):
    topcon.inject("emcy_doubled")
    topcon.inject("error", number=0x23)
    assert topcon.sent[-2:] == [OVERVOLTAGE, OVERVOLTAGE]
