"""A file may have an object of the standard with a type that is not the standard's."""

import pytest

from .declared import DOMAIN, REAL32, TEXT, TIME, bench_of, entry, record

SINGLE = ["1003", "1014", "1015", "100C", "100D", "1017", "1021", "1022", "1F80", "1005"]
RECORDS = ["1003", "1010", "1011", "1016", "1018", "1020", "1028", "1029", "1201"]
FRAMES = [
    "605#4000100000000000",
    "705#R",
    "7E5#0401000000000000",
    "7E5#5A00000000000000",
    "707#05",
    "000#0105",
    "000#8105",
]


def lives(bench, index):
    low, high = index[2:], index[:2]
    for subindex in range(3):
        bench.send(f"605#40{low}{high}{subindex:02X}00000000")
        bench.send(f"605#23{low}{high}{subindex:02X}73617665")
        bench.send(f"605#2F{low}{high}{subindex:02X}01000000")
    for fault in ("bus_off", "error_passive"):
        bench.inject(fault)
        bench.clear(fault)
    for frame in FRAMES:
        bench.send(frame)
    bench.run(1.0)
    assert bench.send("605#4000100000000000") == ["585#4300100000000000"]


@pytest.mark.parametrize("data_type", [TEXT, REAL32, TIME, DOMAIN])
@pytest.mark.parametrize("index", SINGLE)
def test_a_variable_of_another_type_does_no_harm(tmp_path, index, data_type):
    old = "[1017]" if index == "1017" else ""
    lives(bench_of(tmp_path, entry(index, data_type), old, "[3017]" if old else ""), index)


@pytest.mark.parametrize("data_type", [TEXT, REAL32, TIME, DOMAIN])
@pytest.mark.parametrize("index", RECORDS)
def test_a_record_of_another_type_does_no_harm(tmp_path, index, data_type):
    lives(bench_of(tmp_path, record(index, *[(data_type, "")] * 2)), index)


@pytest.mark.parametrize("index", RECORDS)
def test_a_variable_in_the_place_of_a_record_does_no_harm(tmp_path, index):
    lives(bench_of(tmp_path, entry(index, 7)), index)


@pytest.mark.parametrize("index", ["1014", "1015", "100C", "1017", "1F80", "1021"])
def test_a_record_in_the_place_of_a_variable_does_no_harm(tmp_path, index):
    lives(bench_of(tmp_path, record(index, (7, ""), (7, "")), "[1017]", "[3017]"), index)
