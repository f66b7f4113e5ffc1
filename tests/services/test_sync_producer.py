"""SYNC as a node sends it, with and without a counter, and as it hears one (CiA 301, 7.2.5)."""

from pathlib import Path

import pytest
from probe import configure

from canopen_twins import Bench

from .declared import U8, U32, bench_of, entry, record

FILE = Path(__file__).parent.parent / "eds" / "files" / "62_sync_producer.eds"
PRODUCER = entry("1005", U32, "0x40000080") + entry("1006", U32, 100_000)
CONSUMER = entry("1005", U32, "0x80") + entry("1006", U32, 0)
ONCE_MORE = "605#2F00180201000000"


def overflow(value):
    return entry("1019", U8, value)


def syncs(frames):
    return [frame for frame in frames if frame.startswith("080")]


def times(bench, start):
    return [record.time for record in bench.trace if str(record.frame).startswith(start)]


def test_a_producer_sends_sync_every_period_from_its_boot_on():
    bench = Bench(str(FILE), node_id=5)
    assert syncs(bench.run(0.25)) == ["080#", "080#"]
    assert times(bench, "080") == [0.1, 0.2]


def test_its_own_pdos_follow_its_sync(tmp_path):
    bench = bench_of(tmp_path, PRODUCER)
    bench.send("000#0105")
    assert bench.run(0.1) == ["080#", "185#0900"]


def test_its_rpdos_take_over_what_waits(tmp_path):
    bench = bench_of(tmp_path, PRODUCER)
    configure(bench, "605#2F00140201000000")
    bench.send("000#0105")
    bench.send("205#0B00")
    assert bench.sdo[0x2000].raw == 7
    bench.run(0.1)
    assert bench.sdo[0x2000].raw == 11


def test_sync_is_not_sent_in_stopped(tmp_path):
    bench = bench_of(tmp_path, PRODUCER)
    bench.send("000#0205")
    assert bench.run(1.0) == []
    bench.send("000#8005")
    assert bench.run(0.1) == ["080#"]


def test_bit_30_and_the_period_act_when_they_are_written(tmp_path):
    bench = bench_of(tmp_path, CONSUMER)
    configure(bench, "605#2305100080000040")
    assert bench.run(1.0) == []
    configure(bench, "605#2306100010270000")
    assert len(bench.run(0.1)) == 10
    configure(bench, "605#2305100080000000")
    assert bench.run(1.0) == []


def test_what_is_written_elsewhere_does_not_disturb_the_period(tmp_path):
    bench = bench_of(tmp_path, PRODUCER)
    bench.run(0.05)
    configure(bench, "605#2F00180202000000")
    bench.run(0.05)
    assert times(bench, "080") == [0.1]


@pytest.mark.parametrize("value", ["81000040", "81000000", "80000140"])
def test_the_identifier_stays_while_sync_is_sent(tmp_path, value):
    bench = bench_of(tmp_path, PRODUCER)
    assert bench.send(f"605#23051000{value}") == ["585#8005100030000906"]
    configure(bench, "605#2305100080000000", "605#2305100081000040")
    assert bench.run(0.1) == ["081#"]


def test_without_a_period_in_its_dictionary_a_node_cannot_send_sync(tmp_path):
    bench = bench_of(tmp_path, entry("1005", U32, "0x80"))
    assert bench.send("605#2305100080000040") == ["585#8005100030000906"]


def test_a_counter_runs_from_1_to_its_overflow(tmp_path):
    bench = bench_of(tmp_path, PRODUCER + overflow(3))
    assert syncs(bench.run(0.5)) == ["080#01", "080#02", "080#03", "080#01", "080#02"]


def test_a_counter_begins_with_1_whenever_sync_begins(tmp_path):
    bench = bench_of(tmp_path, PRODUCER + overflow(240))
    bench.run(0.2)
    configure(bench, "605#2305100080000000", "605#2305100080000040")
    assert bench.run(0.1) == ["080#01"]
    bench.send("000#0205")
    bench.send("000#0105")
    assert bench.run(0.1)[:1] == ["080#01"]


@pytest.mark.parametrize("value", [1, 241, 255])
def test_a_counter_ends_with_2_to_240(tmp_path, value):
    bench = bench_of(tmp_path, CONSUMER + overflow(0))
    assert bench.send(f"605#2F191000{value:02X}000000") == ["585#8019100030000906"]
    for accepted in (2, 240, 0):
        configure(bench, f"605#2F191000{accepted:02X}000000")


def test_a_counter_changes_while_there_is_no_period_only(tmp_path):
    bench = bench_of(tmp_path, PRODUCER + overflow(0))
    assert bench.send("605#2F1910000A000000") == ["585#8019100022000008"]
    configure(bench, "605#2306100000000000", "605#2F1910000A000000")


def test_what_is_stored_comes_back_whatever_is_fixed_by_then(tmp_path):
    values = (U32, "0x185"), (U8, 1), (6, 0), (U8, 0), (6, 0), (U8, 0)
    tpdo, store = record("1800", *values), record("1010", (U32, 1))
    bench = bench_of(tmp_path, PRODUCER + overflow(0) + tpdo + store)
    configure(
        bench,
        *("605#2305100080000000", "605#2305100090000000", "605#2306100000000000"),
        *("605#2F19100003000000", "605#2306100050C30000", "605#2305100090000040"),
        *("605#2300180185010080", "605#2B00180307000000", "605#2F00180602000000"),
        *("605#2300180195010000", "605#2310100173617665"),
    )
    bench.send("000#8105")
    bench.send("000#0105")
    assert bench.run(0.1) == ["090#01", "090#02", "195#0900"]
    assert bench.sdo[0x1800][3].raw == 7


# What a node hears


@pytest.mark.parametrize(
    ("value", "wrong", "right"),
    [(0, "080#01", "080#"), (10, "080#", "080#01"), (10, "080#0102", "080#0A")],
)
def test_a_sync_of_another_length_is_told_once_and_not_followed(tmp_path, value, wrong, right):
    bench = bench_of(tmp_path, CONSUMER + overflow(value))
    bench.send("000#0105")
    assert bench.send(wrong) == ["085#4082110000000000"]
    assert bench.send(wrong) == []
    assert bench.sdo[0x1001].raw == 0x11
    assert bench.send(right) == ["085#0000000000000000", "185#0900"]
    assert bench.sdo[0x1001].raw == 0


def test_a_node_without_0x1019_takes_sync_of_any_length(tmp_path):
    bench = bench_of(tmp_path, CONSUMER)
    bench.send("000#0105")
    assert bench.send("080#01") == ["185#0900"]


def started(folder, counter, kind, start):
    """TPDO 1 with a SYNC start value."""
    values = (U32, "0x185"), (U8, kind), (6, 0), (U8, 0), (6, 0), (U8, start)
    bench = bench_of(folder, CONSUMER + overflow(counter) + record("1800", *values))
    bench.send("000#0105")
    return bench


def sent_at(bench, counters):
    return [n for n in counters if bench.send(f"080#{n:02X}")]


def test_syncs_count_from_the_start_value_on(tmp_path):
    bench = started(tmp_path, 10, 2, 4)
    assert sent_at(bench, [*range(1, 11), *range(1, 11)]) == [5, 7, 9, 1, 3, 5, 7, 9]


def test_of_type_1_the_sync_of_the_start_value_is_the_first(tmp_path):
    assert sent_at(started(tmp_path, 10, 1, 4), range(1, 7)) == [4, 5, 6]


def test_the_start_value_is_waited_for_again_after_operational(tmp_path):
    bench = started(tmp_path, 10, 1, 4)
    sent_at(bench, range(1, 7))
    bench.send("000#8005")
    bench.send("000#0105")
    assert sent_at(bench, [7, 8, 9, 10, 1, 2, 3, 4, 5]) == [4, 5]


def test_without_a_counter_the_start_value_is_of_no_use(tmp_path):
    bench = started(tmp_path, 0, 1, 4)
    assert bench.send("080#") == ["185#0900"]


def test_the_start_value_changes_while_the_tpdo_is_off_only(tmp_path):
    bench = started(tmp_path, 10, 1, 4)
    assert bench.send("605#2F00180605000000") == ["585#8000180630000906"]
    configure(bench, "605#2300180185010080", "605#2F00180605000000", "605#2300180185010000")
    assert sent_at(bench, range(1, 7)) == [5, 6]


def test_after_the_synchronous_window_an_rpdo_is_discarded(tmp_path):
    bench = bench_of(tmp_path, CONSUMER + entry("1007", U32, 20_000))
    configure(bench, "605#2F00140201000000")
    bench.send("000#0105")
    bench.send("205#0100")  # before any SYNC
    bench.send("080#")
    assert bench.sdo[0x2000].raw == 1
    bench.run(0.02)
    bench.send("205#0200")
    bench.run(0.001)
    bench.send("205#0300")
    bench.send("080#")
    assert bench.sdo[0x2000].raw == 2
    bench.send("205#0400")
    bench.send("080#")
    assert bench.sdo[0x2000].raw == 4


def test_a_synchronous_tpdo_is_within_the_window(tmp_path):
    bench = bench_of(tmp_path, CONSUMER + entry("1007", U32, 1))
    bench.send("000#0105")
    assert [bench.send("080#") for _ in range(2)] == [["185#0900"]] * 2


def test_a_node_that_sends_sync_drives_another(tmp_path):
    other = bench_of(tmp_path, CONSUMER).device
    bench = Bench.of({"producer": (str(FILE), 6), "consumer": (other.eds, 5)})
    bench.send("000#0100")
    assert bench.run(0.1) == ["080#", "186#0900", "185#0900"]
