import json
import logging

import pytest
from probe import Probe, configure

from canopen_twins import Bench
from canopen_twins.slave.memory import Memory

SAVE, LOAD = "605#2310100173617665", "605#231110016C6F6164"
HEARTBEAT, WORD, LIMITED, LEVEL, BYTE = (
    "605#2B171000E8030000",
    "605#2B01200007000000",
    "605#2B032000F9FF0000",
    "605#2B00210005000000",
    "605#2F00200009000000",
)


def values(bench):
    sdo = bench.sdo
    names = "Producer heartbeat", "Word", "Limited", "Level", "Byte"
    return [sdo[name].raw for name in names]


DEFAULTS = [0, 0x1234, 0, 0, 0]
STORED = [1000, 7, -7, 5]


@pytest.fixture
def stored(bench):
    configure(bench, HEARTBEAT, WORD, LIMITED, LEVEL, BYTE, SAVE)
    return bench


@pytest.mark.spec("T-107")
@pytest.mark.parametrize("index", ["1010", "1011"])
def test_both_commands_read_1(bench, index):
    assert bench.send(f"605#40{index[2:]}{index[:2]}0100000000"[:20]) == [
        f"585#43{index[2:]}100101000000"
    ]


@pytest.mark.spec("T-109")
@pytest.mark.parametrize("reset", ["000#8105", "power"])
def test_stored_values_come_back_and_others_do_not(stored, reset):
    if reset == "power":
        stored.power_off()
        stored.power_on()
    else:
        stored.send(reset)
    assert values(stored) == [*STORED, 0]


def test_reset_communication_brings_back_what_is_stored_of_its_area(stored):
    configure(stored, "605#2B17100000000000", "605#2B01200008000000", "605#2B00210006000000")
    stored.send("000#8205")
    assert values(stored) == [1000, 8, -7, 6, 9]


def test_what_is_not_stored_is_lost(bench):
    configure(bench, HEARTBEAT, WORD, LIMITED, LEVEL)
    bench.send("000#8105")
    assert values(bench) == DEFAULTS


def test_what_is_stored_is_the_value_in_force(bench):
    bench.inject("level", value=77)
    configure(bench, SAVE)
    bench.send("000#8105")
    assert bench.sdo["Level"].raw == 77


@pytest.mark.spec("T-109")
@pytest.mark.parametrize("signature", ["00000000", "01000000", "65766173", "6C6F6164", "73617666"])
def test_another_signature_stores_nothing(bench, signature):
    configure(bench, WORD)
    assert bench.send(f"605#23101001{signature}") == ["585#8010100120000008"]
    bench.send("000#8105")
    assert values(bench) == DEFAULTS


@pytest.mark.parametrize("signature", ["00000000", "01000000", "73617665", "64616F6C"])
def test_another_signature_restores_nothing(stored, signature):
    assert stored.send(f"605#23111001{signature}") == ["585#8011100120000008"]
    stored.send("000#8105")
    assert values(stored) == [*STORED, 0]


def test_the_profile_says_how_a_signature_is_refused(bench_of):
    bench = bench_of(store_code=0x08000021)
    assert bench.send("605#2310100100000000") == ["585#8010100121000008"]


def test_defaults_are_in_force_after_the_next_reset_and_not_before(stored):
    configure(stored, LOAD)
    assert values(stored) == [*STORED, 9]
    stored.send("000#8105")
    assert values(stored) == DEFAULTS


def test_the_commands_keep_no_value_of_their_own(stored):
    assert stored.send("605#4010100100000000") == ["585#4310100101000000"]


def test_a_memory_in_a_file_outlives_the_process(tmp_path):
    def start():
        probe = Probe()
        probe.memory = Memory(tmp_path / "probe.json")
        return Bench.of({"probe": probe})

    configure(start(), HEARTBEAT, WORD, LIMITED, LEVEL, SAVE)
    assert values(start()) == [*STORED, 0]


def test_a_memory_that_cannot_be_written_is_told_the_master(tmp_path, caplog):
    folder = tmp_path / "folder"
    folder.mkdir()
    probe = Probe()
    probe.memory = Memory(folder / "probe.json")
    folder.rmdir()
    bench = Bench.of({"probe": probe})
    with caplog.at_level(logging.ERROR):
        assert bench.send(SAVE) == ["585#8010100100000606"]
    assert "cannot be written" in caplog.text


@pytest.mark.parametrize("value", ["6500", "00", "no hex", 5, None], ids=str)
def test_a_stored_value_that_the_device_does_not_take_is_reported_and_left_out(
    tmp_path, caplog, value
):
    path = tmp_path / "probe.json"
    path.write_text(json.dumps({"parameters": {"2003:00": value, "2001:00": "0700"}}))
    probe = Probe()
    probe.memory = Memory(path)
    with caplog.at_level(logging.ERROR):
        bench = Bench.of({"probe": probe})
    assert values(bench) == [0, 7, 0, 0, 0]
    assert ("2003:00" in caplog.text) is (value is not None)


def test_recalled_values_act_like_written_ones(stored):
    stored.send("000#0205")
    stored.send("000#8105")
    assert stored.run(1.0) == ["705#7F"]
    assert stored.device.level == 5


def test_the_profile_says_whether_defaults_are_in_force_at_once(bench_of):
    bench = bench_of(restore_at_once=True)
    configure(bench, HEARTBEAT, WORD, LIMITED, LEVEL, BYTE, SAVE, LOAD)
    assert values(bench) == [*DEFAULTS[:-1], 9]  # the byte is none of those that are stored
    assert (bench.run(5.0), bench.device.level) == ([], 0)
    bench.send("000#8105")
    assert values(bench) == DEFAULTS


def test_the_profile_says_whether_any_value_is_a_signature(bench_of):
    bench = bench_of(store_signature=False)
    configure(bench, HEARTBEAT, WORD, LIMITED, LEVEL, "605#2310100101000000")
    bench.send("000#8105")
    assert values(bench) == [*STORED, 0]
    configure(bench, "605#2311100100000000")
    bench.send("000#8105")
    assert values(bench) == DEFAULTS


def test_the_device_keeps_and_restores_what_only_it_knows(bench):
    bench.device.told.clear()
    assert bench.send("605#2310100100000000") == ["585#8010100120000008"]
    configure(bench, SAVE, LOAD)
    assert bench.device.told == ["save", "restore"]


@pytest.mark.parametrize(("command", "index"), [(SAVE, "1010"), (LOAD, "1110")])
def test_a_device_that_cannot_keep_its_own_tells_the_master(command, index):
    class Full(Probe):
        def save(self):
            raise OSError("no room left")

        restore = save

    assert Bench.of({"probe": Full()}).send(command) == [f"585#80{index}0100000606"]
