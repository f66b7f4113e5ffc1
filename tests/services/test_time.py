"""TIME as a node hears and sends it, and the time stamp of 0x1013 (CiA 301, 7.2.6)."""

import struct
from dataclasses import replace

import pytest
from probe import configure

from .declared import U32, bench_of, entry
from .mapped import mapping

DAY = 86_400_000


def cob_id(value):
    return entry("1012", U32, value)


def time_frame(days, milliseconds):
    return "100#" + struct.pack("<LH", milliseconds, days).hex().upper()


def test_a_producer_sends_days_and_milliseconds_since_1984_every_second(tmp_path):
    bench = bench_of(tmp_path, cob_id("0x40000100"))
    assert bench.run(2.5) == [time_frame(0, 1000), time_frame(0, 2000)]


def test_the_profile_says_how_often(tmp_path):
    bench = bench_of(tmp_path, cob_id("0x40000100"))
    bench.device.profile = replace(bench.device.profile, time_period=0.1)
    bench.send("000#8105")
    assert len(bench.run(1.0)) == 10


def test_time_that_was_heard_goes_on(tmp_path):
    bench = bench_of(tmp_path, cob_id("0xC0000100"))
    bench.run(0.5)
    bench.send(time_frame(15_000, DAY - 200))
    assert bench.run(0.5) == [time_frame(15_001, 300)]


def test_the_bits_above_28_are_not_of_the_time(tmp_path):
    bench = bench_of(tmp_path, cob_id("0xC0000100"))
    bench.send(time_frame(3, 0xF000_0000))
    assert bench.run(1.0) == [time_frame(3, 1000)]


@pytest.mark.parametrize(
    "frame", ["100#", "100#0102030405", "100#01020304050607", "101#010203040506"]
)
def test_what_is_no_time_sets_nothing(tmp_path, frame):
    bench = bench_of(tmp_path, cob_id("0xC0000100"))
    bench.send(frame)
    assert bench.run(1.0) == [time_frame(0, 1000)]


def test_without_bit_31_time_is_not_heard(tmp_path):
    bench = bench_of(tmp_path, cob_id("0x40000100"))
    bench.send(time_frame(3, 0))
    assert bench.run(1.0) == [time_frame(0, 1000)]


def test_time_is_not_sent_in_stopped(tmp_path):
    bench = bench_of(tmp_path, cob_id("0x40000100"))
    bench.send("000#0205")
    assert bench.run(3.0) == []
    bench.send("000#0105")
    assert bench.run(1.0) == [time_frame(0, 4000)]


def test_bit_30_acts_when_it_is_written_and_holds_the_identifier(tmp_path):
    bench = bench_of(tmp_path, cob_id("0x100"))
    assert bench.run(2.0) == []
    configure(bench, "605#2312100000020040")
    assert bench.send("605#2312100001020040") == ["585#8012100030000906"]
    assert [frame[:4] for frame in bench.run(1.0)] == ["200#"]
    configure(bench, "605#2312100000020000", "605#2312100000010000")
    assert bench.run(2.0) == []


def test_the_time_stamp_counts_microseconds_from_what_is_written(tmp_path):
    bench = bench_of(tmp_path, entry("1013", U32, 0))
    bench.run(0.25)
    assert bench.sdo[0x1013].raw == 250_000
    bench.sdo[0x1013].raw = 0xFFFF_FFFF
    bench.run(0.000_011)
    assert bench.sdo[0x1013].raw == 10


def test_the_time_stamp_goes_out_with_a_tpdo(tmp_path):
    stamp = entry("1013", U32, 0).replace("PDOMapping=0", "PDOMapping=1")
    bench = bench_of(tmp_path, stamp + mapping("1A00", 0x10130020))
    bench.send("000#0105")
    bench.run(1.0)
    assert bench.send("080#") == ["185#40420F00"]
