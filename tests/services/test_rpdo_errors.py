"""RPDOs that are too short, too long or too late, and what is told of them (CiA 301, 7.2.2)."""

import pytest
from probe import configure

from .declared import U8, U16, U32, bench_of, record
from .mapped import mapping

TOO_SHORT, TOO_LONG, LATE = "085#1082110000000000", "085#2082110000000000", "085#5082110000000000"
GONE = "085#0000000000000000"


@pytest.fixture
def drive(tmp_path):
    bench = bench_of(tmp_path)
    bench.send("000#0105")
    return bench


def test_an_rpdo_that_is_too_short_is_not_used_and_told_once_until_a_good_one(drive):
    assert drive.send("205#0B") == [TOO_SHORT]
    assert drive.send("205#") == []
    assert drive.sdo[0x2000].raw == 7
    assert drive.sdo[0x1001].raw == 0x11
    assert drive.send("205#0C00") == [GONE]
    assert drive.send("205#0B") == [TOO_SHORT]


def test_an_rpdo_that_is_too_long_is_used_and_told_once_until_a_good_one(drive):
    assert drive.send("205#0B0000") == [TOO_LONG]
    assert drive.send("205#0C000000") == []
    assert drive.sdo[0x2000].raw == 12
    assert drive.send("205#0D00") == [GONE]


def test_from_too_short_to_too_long_both_are_told(drive):
    assert drive.send("205#0B") == [TOO_SHORT]
    assert drive.send("205#0B0000") == [TOO_LONG]
    assert drive.send("205#0B00") == [GONE]


def test_what_was_wrong_is_over_with_operational(drive):
    drive.send("205#0B")
    assert drive.send("000#8005") == [GONE]


def test_what_was_wrong_is_over_with_the_pdo(drive):
    drive.send("205#0B")
    assert drive.send("605#2300140105020080")[1:] == [GONE]


def test_the_profile_says_whether_it_is_told(bench_of):
    bench = bench_of(rpdo_emcy=False)
    bench.send("000#0105")
    assert bench.send("205#0B") == []
    assert len(bench.send("205#0B000000000000")) == 1  # its TPDO, which carries the same byte


def timed(folder, milliseconds, kind=255):
    values = (U32, "0x205"), (U8, kind), (U16, 0), (U8, 0), (U16, milliseconds)
    bench = bench_of(folder, record("1400", *values))
    bench.send("000#0105")
    return bench


@pytest.mark.parametrize("kind", [255, 1])
def test_an_rpdo_that_stays_away_is_told_once_until_it_comes(tmp_path, kind):
    bench = timed(tmp_path, 50, kind)
    assert bench.run(1.0) == []  # before the first nothing is waited for
    bench.send("205#0100")
    assert bench.run(0.049) == []
    bench.send("205#0200")
    assert bench.run(0.049) == []
    assert bench.run(0.001) == [LATE]
    assert bench.run(1.0) == []
    assert bench.send("205#0300") == [GONE]
    assert bench.run(0.05) == [LATE]


def test_one_that_is_too_short_is_as_if_it_had_not_come(tmp_path):
    bench = timed(tmp_path, 50)
    bench.send("205#0100")
    bench.run(0.04)
    bench.send("205#01")
    assert bench.run(0.01) == [LATE]


def test_a_new_event_time_counts_from_the_next_rpdo(tmp_path):
    bench = timed(tmp_path, 50)
    bench.send("205#0100")
    configure(bench, "605#2B00140514000000")
    assert bench.run(1.0) == []
    bench.send("205#0100")
    assert bench.run(0.02) == [LATE]
    configure(bench, "605#2B00140500000000")
    assert bench.send("205#0100") == [GONE]
    assert bench.run(1.0) == []


def test_nothing_is_waited_for_after_operational(tmp_path):
    bench = timed(tmp_path, 50)
    bench.send("205#0100")
    bench.send("000#8005")
    assert bench.run(1.0) == []


def test_of_two_rpdos_each_has_an_error_of_its_own(tmp_path):
    second = record("1401", (U32, "0x305"), (U8, 255)) + mapping("1601", 0x20000010)
    bench = bench_of(tmp_path, second)
    bench.send("000#0105")
    assert bench.send("205#01") == [TOO_SHORT]
    assert bench.send("305#01") == [TOO_SHORT]
    assert bench.send("205#0100") == []
    assert bench.send("305#0100") == [GONE]
