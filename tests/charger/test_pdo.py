import pytest
from charger_bus import (
    ENTER_PREOP,
    LOCKED,
    RELEASED,
    START,
    STOP,
    put,
    refused,
    release,
    status,
    value,
)

from canopen_twins import Bench

IDLE = ["1E3#0000000000000000", "2E3#0000000000000300", "3E3#0000000000000000"]
AT_20_KV = ["1E3#2943282800000000", "2E3#204ED00790010300", "3E3#0000000000000000"]


@pytest.fixture
def operational(quiet):
    put(quiet, {0x02: 8, 0x08: 20_000})
    assert quiet.send(START) == IDLE
    return quiet


@pytest.mark.spec("C-097", "C-096", "A-23", "A-24")
def test_a_set_at_entering_operational_and_one_each_cycle(operational):
    assert operational.run(0.49) == []
    assert operational.run(0.02) == IDLE
    assert operational.run(2.0) == IDLE * 4


@pytest.mark.spec("C-092", "C-093", "C-094", "C-145", "C-165", "C-162")
def test_what_the_three_carry(operational):
    operational.send(RELEASED)
    operational.run(0.6)
    assert operational.run(0.5) == AT_20_KV


@pytest.mark.spec("C-097", "A-24")
def test_a_change_is_not_sent_before_its_time(operational):
    assert operational.send(RELEASED) == []
    assert operational.run(0.49) == []
    assert operational.run(0.02)[1] == "2E3#204ED00790010300"


@pytest.mark.spec("A-24")
def test_the_other_reading_sends_it_at_once():
    bench = Bench("charger", tpdo_on_change=True)
    put(bench, {0x02: 8})
    bench.send(START)
    assert bench.send(RELEASED) == ["1E3#2900000000000000"]


@pytest.mark.spec("C-096", "C-098")
@pytest.mark.parametrize("milliseconds", [100, 730, 60_000])
def test_a_new_cycle_begins_with_the_write(operational, milliseconds):
    operational.run(0.3)
    put(operational, {0x01: milliseconds})
    assert operational.run(milliseconds / 1000 - 0.01) == []
    assert operational.run(0.02) == IDLE
    assert operational.run(milliseconds / 1000 - 0.02) == []
    assert operational.run(0.02) == IDLE


@pytest.mark.spec("C-096")
@pytest.mark.parametrize(("milliseconds", "code"), [(99, 0x06090032), (60_001, 0x06090031)])
def test_the_cycle_has_its_limits(bench, milliseconds, code):
    with refused(code):
        put(bench, {0x01: milliseconds})
    assert value(bench, 0x01) == 500


@pytest.mark.spec("C-090")
@pytest.mark.parametrize("command", [ENTER_PREOP, STOP])
def test_outside_operational_none_is_sent_nor_heard(operational, command):
    operational.send(command)
    assert operational.send(RELEASED) == []
    assert operational.run(10.0) == []
    operational.send(ENTER_PREOP)
    assert status(operational) == 0x00


@pytest.mark.spec("C-090", "C-097")
def test_a_cycle_written_before_operational_counts_from_there(quiet):
    put(quiet, {0x01: 1000})
    quiet.run(0.7)
    quiet.send(START)
    assert quiet.run(0.99) == []
    assert quiet.run(0.02) == IDLE


@pytest.mark.spec("C-091", "C-135", "C-137")
def test_the_rpdo_releases_and_locks_on_reception(operational):
    operational.send(RELEASED)
    assert status(operational) == 0x29
    operational.send(LOCKED)
    assert status(operational) == 0x00


@pytest.mark.spec("C-135", "A-46")
def test_without_the_bit_of_canopen_the_rpdo_has_no_effect(operational):
    put(operational, {0x02: 4})
    operational.send(RELEASED)
    assert status(operational) == 0x00
    operational.inject("hmi_on")
    operational.send(LOCKED)
    operational.send("263#55")
    assert status(operational) == 0x29


@pytest.mark.spec("C-137", "A-45")
@pytest.mark.parametrize("byte", ["01", "0E", "10", "55", "8F", "FF"])
def test_a_byte_that_is_neither_locks(operational, byte):
    operational.send(RELEASED)
    operational.send(f"263#{byte}")
    assert status(operational) == 0x00


@pytest.mark.spec("C-099", "A-25")
def test_an_empty_one_is_ignored_and_bytes_beyond_the_first_are(operational):
    operational.send("263#0FAABBCC00000000")
    assert status(operational) == 0x29
    operational.send("263#")
    assert status(operational) == 0x29
    operational.send("263#000F0F0F")
    assert status(operational) == 0x00
    assert operational.sdo[0x1001].raw == 0


@pytest.mark.spec("C-095")
def test_nothing_of_them_can_be_changed(bench):
    parameters = [(0x1400, 3), (0x1800, 3), (0x1801, 3), (0x1802, 3)]
    mappings = [(0x1600, 2), (0x1A00, 9), (0x1A01, 5), (0x1A02, 5)]
    for index, count in parameters + mappings:
        for subindex in range(count):
            before = value(bench, subindex, index)
            with refused(0x06010002):
                bench.sdo[index][subindex].raw = before
            assert value(bench, subindex, index) == before


@pytest.mark.spec("C-091", "C-092", "C-093", "C-094")
def test_identifiers_and_types_are_as_printed(bench):
    records = (0x1400, 0x1800, 0x1801, 0x1802)
    cob_ids = [value(bench, 1, index) for index in records]
    assert cob_ids == [0x263, 0x1E3, 0x2E3, 0x3E3]
    assert [value(bench, 2, index) for index in records] == [255] * 4


@pytest.mark.spec("C-202", "A-19")
def test_what_the_variant_has_not_is_sent_as_0_or_not_at_all():
    assert len(Bench("charger").send(START)) == 3
    assert len(Bench("charger", tpdo3_without_discharge="off").send(START)) == 2
    for variant in ("A", "C"):
        bench = Bench("charger", variant=variant, tpdo3_without_discharge="off")
        assert len(bench.send(START)) == 3


@pytest.mark.spec("C-093", "C-162", "C-163", "A-54")
def test_a_limiter_is_told_beside_the_mode():
    bench = Bench("charger", heartbeat_default_ms=0)
    release(bench)
    put(bench, {0x08: 30_000})
    bench.run(1.0)
    bench.send(START)
    assert bench.sent[-2] == "2E3#A566DE0EE8030304"  # 26.28 kV, 3806 uA, 100.0 W


@pytest.mark.spec("C-092", "C-145", "C-190", "C-200")
def test_a_charger_that_discharges_says_so(quiet):
    bench = Bench("charger", variant="A", heartbeat_default_ms=0, web_speed=2.0)
    put(bench, {0x22: 1, 0x27: 0})
    bench.run(0.1)
    assert bench.send(START) == [
        "1E3#11000000001F0000",  # HV on, discharging, 31 % of its current
        "2E3#0000000000000300",
        "3E3#8813AE03F1FF0200",  # 5000 V, 942 uA, -15 uA, 0.2 W
    ]
