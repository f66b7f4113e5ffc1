from itertools import pairwise

import pytest

from canopen_twins import Bench

from .bus import ENTER_PREOP, START, STOP, heard, read, word

SENSORS = dict.fromkeys((4900, 4901, 4906, 4917, 4827, 4835), 3)
WATCHING = {428: 127, 430: 100, 429: 0}


@pytest.fixture
def fed(configured):
    """With the CANopen inputs of the manual's examples, in Operational."""
    bench = configured({**SENSORS, 16460: 0, 16472: 0}, {429: 0})
    bench.send(START)
    bench.run(0.1)
    return bench


@pytest.mark.spec("G-040", "G-041", "G-042", "G-056", "G-030")
def test_binary_tpdos_have_eight_four_and_two_bytes(configured):
    bench = configured({14402: 1, 16460: 0, 16472: 0}, {429: 0})
    bench.send(START)
    sent = bench.run(0.017)
    assert heard(sent, "181") == ["0000000000000000"]
    assert heard(sent, "281") == ["00000000"]
    assert len(heard(sent, "381")[0]) == 4


@pytest.mark.spec("G-042", "G-043", "G-044")
def test_without_a_change_they_are_silent_for_ever(configured):
    bench = configured({16460: 0, 16472: 0}, {429: 0})
    bench.send(START)
    bench.run(0.1)
    assert bench.run(60.0) == []
    bench.inject("error", unit="governor", number=3001)
    assert bench.run(1.0) == ["181#0200000000000000"]


@pytest.mark.spec("G-060", "G-062", "G-064", "G-067", "G-066")
def test_analogue_tpdos_are_little_endian_and_on_time(configured):
    bench = configured({16461: 100, 16404: 2300, 16405: 0, 16406: 2917}, {16404: 0x3E5, 429: 0})
    bench.run(10.0)
    bench.send(START)
    bench.run(3.0)
    times = [record.time for record in bench.trace if record.frame.can_id == 0x3E5]
    assert [b - a for a, b in pairwise(times)] == pytest.approx([0.09375] * (len(times) - 1))
    assert len(times) == 32
    sent = heard(bench.run(0.2), "481")[-1]
    assert int.from_bytes(bytes.fromhex(sent)[:2], "little") == 16 * 1500
    assert {len(data) for data in heard(bench.sent, "3E5")} == {8}  # two words of four


@pytest.mark.spec("G-052", "G-060", "G-067")
def test_what_is_sent_is_in_the_dictionary(bench):
    bench.send(START)
    bench.run(20.0)
    last = bytes.fromhex(heard(bench.sent, "481")[-1])
    for sub in (1, 2, 3, 4):
        assert read(bench, 0x2001, sub) == int.from_bytes(last[2 * sub - 2 : 2 * sub], "little")


@pytest.mark.spec("G-064", "G-031", "G-014", "G-015")
@pytest.mark.parametrize("command", [STOP, ENTER_PREOP])
def test_no_pdo_leaves_outside_operational(bench, command):
    assert heard(bench.run(1.0), "481") == []
    bench.send(START)
    assert len(heard(bench.run(1.0), "481")) == 64
    bench.send(command)
    assert {frame[:4] for frame in bench.run(2.0)} == {"701#"}


@pytest.mark.spec("G-053", "G-099", "G-100")
def test_words_of_rpdos_are_in_the_dictionary(fed):
    fed.send("201#341200000040")
    fed.send("301#01020304")
    fed.send("401#AAAABBBB0506")
    assert [read(fed, 0x2003, sub) for sub in (1, 2)] == [0x1234, 0x4000]
    assert [read(fed, 0x2004, sub) for sub in (1, 2, 7)] == [0x0201, 0x0403, 0x0605]
    fed.send(ENTER_PREOP)
    fed.send("201#FFFFFFFFFFFF")
    assert read(fed, 0x2003, 1) == 0x1234


@pytest.mark.spec("G-106")
@pytest.mark.parametrize(("data", "value"), [("010203", 0), ("01020304FF", 0x0201), ("R", 0)])
def test_short_rpdos_are_ignored_and_long_ones_cut(fed, data, value):
    fed.send(f"301#{data}")
    assert read(fed, 0x2004, 1) == value


@pytest.mark.spec("G-004", "G-085")
def test_what_rpdos_bring_cannot_be_written(fed):
    (answer,) = fed.send("601#2B03200101000000")
    assert answer == "581#8003200102000106"
    assert read(fed, 0x2003, 1) == 0


@pytest.mark.spec("G-070", "G-071", "G-072", "G-074")
def test_identifiers_and_mappings_are_those_in_force(bench):
    assert [read(bench, 0x1800 + n, 1) for n in (0, 1, 3, 15)] == [0x181, 0x281, 0x481, 0x57F]
    assert [read(bench, 0x1400 + n, 1) for n in range(4)] == [0x201, 0x301, 0x401, 0x501]
    assert read(bench, 0x1802, 1) == 0x80000381  # not active: as in the EDS
    assert read(bench, 0x1804, 1) == 0x80000001
    assert [read(bench, 0x1600, sub) for sub in range(4)] == [
        3,
        0x20030110,
        0x00060010,
        0x20030210,
    ]
    assert [read(bench, 0x1A03, sub) for sub in range(5)] == [
        4,
        *(0x20010010 | sub << 8 for sub in (1, 2, 3, 4)),
    ]
    assert read(bench, 0x1A02) == 0


@pytest.mark.spec("G-050", "G-051", "G-052", "G-053", "G-055")
def test_the_number_of_entries_is_the_highest(configured):
    bench = configured({**SENSORS, 14402: 1})
    assert [read(bench, 0x2000 + n) for n in range(5)] == [7, 51, 50, 2, 12]
    assert read(bench, 0x2000, 7) & 0xFF00 == 0


@pytest.mark.spec("G-073")
def test_pdos_are_of_the_event_type_and_without_inhibit_time(bench):
    for index in [*range(0x1400, 0x1404), *range(0x1800, 0x1810)]:
        assert [read(bench, index, sub) for sub in (0, 2, 3, 4, 5)] == [5, 0xFE, 0, 0, 0]


@pytest.mark.spec("G-113", "G-114")
@pytest.mark.parametrize("content", ["00", "04", "05", "7F"])
def test_any_heartbeat_of_the_partner_counts(configured, content):
    bench = configured(gateway=WATCHING)
    bench.send(START)
    for _ in range(10):
        assert bench.send(f"77F#{content}") == []
        bench.run(0.09)
    assert word(bench) == 0
    bench.run(0.1)
    assert word(bench) == 0x0200
    bench.send(f"77F#{content}")
    bench.run(0.03)
    assert word(bench) == 0


@pytest.mark.spec("G-114")
@pytest.mark.parametrize("frame", ["77F#", "77F#0500", "77F#R", "77E#05", "0000077F#05"])
def test_what_is_no_heartbeat_of_the_partner_does_not(configured, frame):
    bench = configured(gateway=WATCHING)
    bench.send(START)
    bench.send("77F#05")
    for _ in range(4):
        bench.run(0.09)
        bench.send(frame)
    assert word(bench) == 0x0200


@pytest.mark.spec("G-113")
@pytest.mark.parametrize(("limit", "entry"), [(100, 0x7F0064), (0, 0)])
def test_the_partner_is_in_the_dictionary(configured, limit, entry):
    bench = configured(gateway={428: 127, 430: limit})
    assert read(bench, 0x1016, 1) == entry


@pytest.mark.spec("G-220")
def test_the_identity_is_that_of_the_parameters(bench):
    assert [read(bench, 0x1018, sub) for sub in range(5)] == [4, 0x161, 0x1B59, 0, 405 << 16 | 1]


@pytest.mark.parametrize(("arm", "expected"), [("heartbeat", 0), ("operational", 0x0200)])
def test_when_monitoring_of_the_partner_begins_can_be_chosen(configured, arm, expected):
    bench = configured(gateway=WATCHING, arm=arm)
    bench.send(START)
    bench.run(0.5)
    assert word(bench) == expected


@pytest.mark.parametrize(("first", "count"), [("always", 2), ("nonzero", 0), ("never", 0)])
def test_the_first_binary_tpdo_can_be_chosen(configured, first, count):
    bench = configured({16460: 0, 16472: 0}, {429: 0}, first_tpdo=first)
    bench.send(START)
    assert len(bench.run(1.0)) == count


def test_another_main_cycle_is_another_grid(configured):
    bench = configured({16472: 0, 14401: 0}, {429: 0}, governor_cycle=0.02)
    bench.send(START)
    assert len(bench.run(1.0)) == 50


def test_other_parameters_are_as_the_settings_say(configured):
    bench = configured(boot_time=1.0)
    assert bench.sent == []
    assert bench.run(0.8) == ["701#00"]


@pytest.mark.spec("G-191")
def test_the_lowest_supply_can_be_chosen():
    bench = Bench("gateway", lowest_voltage=20.0)
    bench.run(1.0)
    bench.inject("supply", volts=18)
    bench.run(0.1)
    assert read(bench, 0x1001) == 0b101


def test_the_error_register_can_be_switched_off():
    bench = Bench("gateway", error_register="zero")
    bench.run(1.0)
    bench.inject("supply", volts=7)
    bench.run(0.1)
    assert read(bench, 0x1001) == 0


def test_tables_can_be_replaced(tmp_path, configured):
    scaling, bits = tmp_path / "scaling.csv", tmp_path / "bits.yaml"
    scaling.write_text("number,full_scale,unit,counts\n2000,3000,rpm,30000\n")
    rows = "\n".join(f"  {n}: []" for n in range(2, 7))
    bits.write_text(f"error bits:\n  1: [~, ~, 3001]\n{rows}\nengine state bits: [~, running]\n")
    bench = configured({14402: 1}, scaling=str(scaling), error_bits=str(bits))
    bench.send(START)
    bench.run(30.0)
    assert read(bench, 0x2001, 1) == 15000
    assert read(bench, 0x2000, 7) == 0b10
    bench.inject("error", unit="governor", number=3001)
    bench.run(0.1)
    assert [read(bench, 0x2000, sub) for sub in range(1, 7)] == [0b100, 0, 0, 0, 0, 0]


def told(configured, rests):
    bench = configured({16460: 16, 16461: 100, 16404: 2300}, {16404: 0x3E5})
    if not rests:
        bench.device.__class__ = type("Restless", (type(bench.device),), {"rest": 0.0})
    bench.send(START)
    for fault in ("reset", "link_cut", "supply", "can2_bus_fault"):
        bench.inject(fault)
        bench.run(0.6)
        bench.clear(fault)
        bench.run(0.6)
        bench.send(START)
    return [str(record) for record in bench.trace]


@pytest.mark.spec("G-008")
def test_what_is_left_out_at_rest_is_not_to_be_seen(configured):
    assert told(configured, rests=True) == told(configured, rests=False)
