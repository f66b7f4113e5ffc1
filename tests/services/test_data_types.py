"""Objects of every data type, over SDO, as a file declares them."""

import struct

import pytest
from canopen.sdo.exceptions import SdoAbortedError

from .declared import (
    BOOLEAN,
    DIFFERENCE,
    DOMAIN,
    OCTETS,
    REAL32,
    TEXT,
    TIME,
    U64,
    bench_of,
    entry,
)

I24, UNICODE, REAL64 = 0x10, 0x0B, 0x11
TOO_LONG, TOO_SHORT, TOO_HIGH, TOO_LOW = 0x06070012, 0x06070013, 0x06090031, 0x06090032


def download(bench, value, block=False):
    """The abort code of a write to 2002h, none if it was taken; the whole value is read back."""
    client = bench.sdo
    try:
        with client[0x2002].open("wb", size=len(value), block_transfer=block) as file:
            file.write(value)
    except SdoAbortedError as refusal:
        return refusal.code
    assert upload(bench) == upload(bench, block=True) == value
    return None


def upload(bench, block=False):
    with bench.sdo[0x2002].open("rb", block_transfer=block) as file:
        return file.read()


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize(
    ("data_type", "value"),
    [
        (BOOLEAN, b"\x01"),
        (I24, b"\xfb\xff\xff"),
        (U64, bytes(range(8))),
        (REAL32, struct.pack("<f", 1.5)),
        (REAL64, struct.pack("<d", -1e300)),
        (TEXT, b"four"),
        (TEXT, b"a text of more than seven bytes"),
        (UNICODE, "Größe".encode("utf-16-le")),
        (OCTETS, bytes(9)),
        (TIME, bytes(range(6))),
        (DIFFERENCE, bytes(range(6))),
        (DOMAIN, bytes(range(256)) * 40),
    ],
)
def test_a_value_is_written_and_read_as_it_is(tmp_path, data_type, value, block):
    bench = bench_of(tmp_path, entry("2002", data_type))
    assert download(bench, value, block) is None


@pytest.mark.parametrize("data_type", [TIME, DIFFERENCE])
def test_a_time_has_six_bytes(tmp_path, data_type):
    bench = bench_of(tmp_path, entry("2002", data_type))
    assert bench.send("605#4002200000000000") == ["585#4102200006000000"]
    assert bench.send("605#2302200001020304") == ["585#8002200013000706"]
    assert download(bench, bytes(7)) == TOO_LONG


def test_a_time_of_the_file_is_its_default(tmp_path):
    bench = bench_of(tmp_path, entry("2002", TIME, "2 1000"))
    assert upload(bench) == struct.pack("<LH", 1000, 2)


@pytest.mark.parametrize(
    ("value", "answer"), [("00", "60"), ("01", "60"), ("02", "80"), ("FF", "80")]
)
def test_a_boolean_is_0_or_1(tmp_path, value, answer):
    bench = bench_of(tmp_path, entry("2002", BOOLEAN, 1))
    (told,) = bench.send(f"605#2F022000{value}000000")
    assert told[4:6] == answer
    assert answer == "60" or told[12:] == "31000906"


@pytest.mark.parametrize(("data_type", "code"), [(REAL32, "<f"), (REAL64, "<d")])
@pytest.mark.parametrize(
    ("value", "refusal"),
    [
        (0.1, None),
        (-0.1, None),
        (0.0, None),
        (0.11, TOO_HIGH),
        (float("inf"), TOO_HIGH),
        (float("nan"), TOO_HIGH),
        (-0.11, TOO_LOW),
    ],
)
def test_numbers_with_a_fraction_have_limits(tmp_path, data_type, code, value, refusal):
    limits = "LowLimit=-0.1\nHighLimit=0.1\n"
    bench = bench_of(tmp_path, entry("2002", data_type, 0, more=limits))
    assert download(bench, struct.pack(code, value)) == refusal


def test_without_limits_any_number_is_taken(tmp_path):
    bench = bench_of(tmp_path, entry("2002", REAL32))
    assert download(bench, struct.pack("<f", float("nan"))) is None


def test_what_is_written_does_not_fill_the_memory(tmp_path):
    bench = bench_of(tmp_path, entry("2002", DOMAIN))
    assert bench.send("605#2102200001001000") == ["585#8002200012000706"]
