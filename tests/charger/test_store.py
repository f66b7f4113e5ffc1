import logging

import pytest
from charger_bus import (
    LOAD,
    LOADED,
    RESET_COMMUNICATION,
    RESET_NODE,
    SAVE,
    SAVED,
    ask,
    put,
    refused,
    release,
    restart,
    status,
    value,
)

from canopen_twins import Bench, devices
from canopen_twins.slave.memory import Memory

OTHERS = {  # a value for every entry of 0x2002 that is kept, in an order in which each is legal
    0x01: 700,
    0x02: 0x0C,
    0x03: 1,
    0x04: 2000,
    0x0D: 25_000,
    0x0C: 2000,
    0x0F: 4000,
    0x0E: 300,
    0x10: 4,
    0x11: 900,
    0x14: 4000,
    0x13: 100,
    0x12: 200,
    0x15: 2000,
    0x08: 12_345,
    0x09: 1234,
    0x0B: 1,
    0x16: 30,
    0x17: 15,
    0x18: 77,
    0x19: 1,
    0x1A: 123_456_789,
    0x1B: 0,
    0x1D: 1,
    0x1E: 4321,
    0x21: 50,
    0x22: 1,
    0x25: 17,
    0x26: 3,
    0x27: 0,
    0x28: 1,
    0x29: 111,
    0x2A: 222,
}
RESTARTS = pytest.mark.parametrize("how", [RESET_NODE, "power"])


@pytest.fixture
def full():
    """A charger with every parameter there is, changed."""
    bench = Bench("charger", variant="A", kind="PCSC")
    put(bench, OTHERS)
    bench.sdo[0x1017].raw = 300
    return bench


def parameters(bench):
    entries = bench.device.dictionary()[0x2002].subindices
    return {
        sub: value(bench, sub)
        for sub, entry in entries.items()
        if entry.access_type == "rw" and sub not in (0x06, 0x07, 0x1C)
    }


@pytest.mark.spec("C-114", "C-116")
def test_both_objects_say_that_they_act_on_command(bench):
    for index in ("10", "11"):
        assert bench.send(f"663#40{index}100000000000") == [f"5E3#4F{index}100001000000"]
        assert bench.send(f"663#40{index}100100000000") == [f"5E3#43{index}100101000000"]


@pytest.mark.spec("C-114", "C-117", "A-32")
@RESTARTS
def test_every_saved_value_comes_back_as_it_was(full, how):
    before = parameters(full)
    assert set(before) == set(OTHERS)
    assert full.send(SAVE) == SAVED
    put(full, {sub: v for sub, v in OTHERS.items() if sub in (0x02, 0x16)})
    put(full, {0x16: 25, 0x11: 100, 0x10: 3, 0x0B: 99, 0x01: 100})
    restart(full, how)
    assert parameters(full) == before
    assert full.sdo[0x1017].raw == 300


@pytest.mark.spec("C-117")
@RESTARTS
def test_what_was_not_saved_is_lost(full, how):
    fresh = parameters(Bench("charger", variant="A"))
    restart(full, how)
    assert parameters(full) == fresh
    assert full.sdo[0x1017].raw == 1000


@pytest.mark.spec("C-117", "C-153", "A-52")
def test_saved_values_are_not_converted_into_each_other(bench):
    put(bench, {0x0B: 1})  # raised to the lowest voltage, and still 1 %
    assert (value(bench, 0x08), value(bench, 0x0B)) == (1500, 1)
    bench.send(SAVE)
    bench.send(RESET_NODE)
    assert (value(bench, 0x08), value(bench, 0x0B)) == (1500, 1)


@pytest.mark.spec("C-114", "A-31")
@pytest.mark.parametrize("signature", ["00000000", "01000000", "65766173", "6C6F6164"])
def test_without_its_signature_nothing_is_saved(bench, signature):
    put(bench, {0x08: 5000})
    assert bench.send(f"663#23101001{signature}") == ["5E3#8010100120000008"]
    bench.send(RESET_NODE)
    assert value(bench, 0x08) == 1500


@pytest.mark.spec("C-115", "A-31")
def test_without_its_signature_nothing_is_restored(bench):
    put(bench, {0x08: 5000})
    assert bench.send("663#2311100173617665") == ["5E3#8011100120000008"]
    assert value(bench, 0x08) == 5000


@pytest.mark.spec("A-31")
def test_by_the_other_reading_any_access_will_do():
    bench = Bench("charger", signature="any")
    put(bench, {0x08: 5000})
    assert bench.send("663#2310100101000000") == SAVED
    bench.send(RESET_NODE)
    assert value(bench, 0x08) == 5000
    assert bench.send("663#2311100100000000") == LOADED
    assert value(bench, 0x08) == 1500


@pytest.mark.spec("C-115", "A-32")
def test_restoring_acts_at_once_and_after_every_restart(full):
    fresh = parameters(Bench("charger", variant="A"))
    full.send(SAVE)
    put(full, {0x1C: 1})
    assert full.send(LOAD) == LOADED
    assert parameters(full) == fresh
    assert value(full, 0x1C) == 0
    assert full.sdo[0x1017].raw == 1000
    full.send(RESET_NODE)
    assert parameters(full) == fresh


@pytest.mark.spec("C-115", "A-32")
def test_restoring_leaves_node_id_and_bit_timing_alone(bench):
    put(bench, {0x06: 42, 0x07: 2})
    bench.send(SAVE)
    bench.send(LOAD)
    assert (value(bench, 0x06), value(bench, 0x07)) == (42, 2)
    assert bench.send(RESET_NODE) == ["72A#00"]


@pytest.mark.spec("C-115", "A-32", "A-41")
def test_restoring_takes_a_release_by_canopen_away(bench):
    release(bench)
    bench.send(LOAD)
    assert status(bench) == 0x00
    assert value(bench, 0x02) == 4


@pytest.mark.spec("C-120")
@RESTARTS
def test_the_keyboard_lock_is_never_kept(bench, how):
    put(bench, {0x1C: 1})
    bench.send(SAVE)
    restart(bench, how)
    assert value(bench, 0x1C) == 0


@pytest.mark.spec("C-008", "C-117", "A-26")
def test_a_reset_of_the_communication_brings_back_only_its_area(bench):
    bench.sdo[0x1017].raw = 300
    put(bench, {0x08: 5000, 0x01: 700})
    bench.send(SAVE)
    bench.sdo[0x1017].raw = 400
    put(bench, {0x08: 6000, 0x01: 800})
    bench.send(RESET_COMMUNICATION)
    assert bench.sdo[0x1017].raw == 300
    assert (value(bench, 0x08), value(bench, 0x01)) == (6000, 800)


@pytest.mark.spec("C-114", "C-055")
def test_a_worn_memory_refuses_and_keeps_what_it_has(bench):
    put(bench, {0x08: 5000})
    bench.send(SAVE)
    bench.inject("memory_failure")
    put(bench, {0x08: 6000})
    for command, index in ((SAVE, "1010"), (LOAD, "1110")):
        assert bench.send(command) == [f"5E3#80{index}0100000606"]
    assert value(bench, 0x08) == 6000
    bench.send(RESET_NODE)
    assert value(bench, 0x08) == 5000
    bench.clear("memory_failure")
    assert bench.send(SAVE) == SAVED


def start(path, **settings):
    device = devices.create("charger", **settings)
    device.memory = Memory(path)
    return Bench.of({"charger": device})


@pytest.mark.spec("C-117", "C-185", "A-17")
def test_a_file_outlives_the_process(tmp_path):
    path = tmp_path / "charger.json"
    bench = start(path)
    release(bench)
    put(bench, {0x06: 42})
    bench.send(SAVE)
    bench.run(90 * 60.0)
    bench.power_off()
    bench = start(path)
    assert bench.sent == ["72A#00"]
    assert value(bench, 0x08) == 20_000
    assert [value(bench, sub, 0x2000) for sub in range(1, 9)] == [0, 0, 1, 30, 0, 0, 1, 30]


@pytest.mark.spec("C-185")
def test_hours_are_kept_by_the_minute_whatever_happens(tmp_path):
    path = tmp_path / "charger.json"
    start(path).run(119.0)  # and then nobody switches it off
    bench = start(path)
    assert value(bench, 4, 0x2000) == 1
    bench.run(60.0)
    assert value(bench, 4, 0x2000) == 2


@pytest.mark.spec("C-185")
def test_hours_survive_power_store_restore_and_resets(bench):
    release(bench)
    bench.run(3600.0)
    for act in (SAVE, LOAD, RESET_NODE, RESET_COMMUNICATION, "power"):
        restart(bench, act)
    assert [value(bench, sub, 0x2000) for sub in (3, 4, 7, 8)] == [1, 0, 1, 0]


@pytest.mark.spec("C-185")
def test_a_worn_memory_loses_the_hours_and_says_so_only_in_the_log(bench, caplog):
    bench.run(61.0)
    bench.inject("memory_failure")
    with caplog.at_level(logging.ERROR):
        bench.run(3600.0)  # at rest they are kept once an hour
    assert "hour counters" in caplog.text
    restart(bench, "power")
    assert value(bench, 4, 0x2000) == 1


DAMAGED = [
    {"charger parameters": {"VOLTAGE_SETPOINT": "20000"}},
    {"charger parameters": {"VOLTAGE_SETPOINT": 20_000.0}},
    {"charger parameters": {"VOLTAGE_SETPOINT": True}},
    {"charger parameters": {"VOLTAGE_SETPOINT": 30_001}},
    {"charger parameters": {"VOLTAGE_SETPOINT": 20_000, "VOLTAGE_MAXIMUM": 19_999}},
    {"charger parameters": {"MODE": 7}},
    {"charger parameters": {"VOLTAGE": 20_000}},
    {"network": {"node_id": 128, "bit_timing": 4}},
    {"network": {"node_id": 0}},
    {"network": {"bit_timing": 5}},
    {"network": {"channel": 1}},
    {"hours": {"operating": -1}},
    {"hours": {"charging": None}},
    {"hours": {"minutes": 3}},
]


@pytest.mark.parametrize("content", DAMAGED, ids=str)
def test_a_damaged_section_is_told_and_left_out(tmp_path, caplog, content):
    path = tmp_path / "charger.json"
    memory = Memory(path)
    memory.store("charger parameters", {"RAMP_TIME": 600})
    for section, values in content.items():
        memory.store(section, values)
    with caplog.at_level(logging.ERROR):
        bench = start(path)
    assert f"stored {next(iter(content))}" in caplog.text
    assert bench.sent == ["763#00"]
    assert value(bench, 0x08) == 1500
    assert value(bench, 0x11) == (500 if "charger parameters" in content else 600)


def test_what_another_type_has_stored_is_left_out(tmp_path):
    path = tmp_path / "charger.json"
    bench = start(path, kind="PCMT")
    put(bench, {0x08: 50_000, 0x06: 42})
    bench.send(SAVE)
    bench = start(path, kind="PCSC")
    assert bench.sent == ["72A#00"]  # a place has every type
    assert value(bench, 0x08) == 1500


@pytest.mark.spec("C-117")
def test_a_refused_write_is_not_saved_either(bench):
    with refused(0x06090031):
        put(bench, {0x08: 30_001})
    bench.send(SAVE)
    bench.send(RESET_NODE)
    assert ask(bench, 0x2002, 0x08) == ["5E3#4B022008DC050000"]
