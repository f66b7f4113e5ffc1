"""PDOs that carry bits, parts of objects, texts and gaps, by the file of a device."""

from pathlib import Path

import pytest
from probe import configure

from canopen_twins import Bench
from canopen_twins.diagnosis.decoder import Decoder

from .declared import BOOLEAN, DOMAIN, OCTETS, TEXT, U8, U16, U32, U64, bench_of, entry, record
from .mapped import mappable, mapping

FILES = Path(__file__).parent.parent / "eds" / "files"
I8 = 2


def started(bench):
    bench.send("000#0105")
    return bench


def of_file(name):
    return started(Bench(str(FILES / name), node_id=5))


def tpdo(folder, *parts, objects=""):
    return started(bench_of(folder, mapping("1A00", *parts) + objects))


def rpdo(folder, *parts, objects="", **options):
    return started(bench_of(folder, mapping("1600", *parts) + objects, **options))


def test_a_pdo_without_a_mapping_record_does_not_exist():
    bench = of_file("28_pdo_without_mapping.eds")
    assert bench.send("080#") == []
    assert bench.send("185#R") == []
    assert bench.send("605#4000180100000000") == ["585#8000180100000206"]


def test_a_pdo_that_maps_what_is_not_there_is_off_and_stays_off():
    bench = of_file("29_mapping_of_nothing.eds")
    assert bench.send("080#") == []
    assert bench.send("605#4000180100000000") == ["585#4300180185010080"]
    assert bench.send("605#2300180185010000") == ["585#8000180130000906"]
    assert bench.send("205#0B00") == []
    assert bench.sdo[0x2000].raw == 11


def test_it_comes_into_being_with_another_mapping():
    bench = of_file("29_mapping_of_nothing.eds")
    configure(
        bench,
        "605#2F001A0000000000",
        "605#23001A0110000120",
        "605#2F001A0001000000",
        "605#2300180185010000",
    )
    assert bench.send("080#") == ["185#0900"]


@pytest.mark.parametrize(
    ("name", "sent"),
    [
        ("42_bits_in_a_tpdo.eds", "185#57"),
        ("45_text_in_a_tpdo.eds", "185#4142434445464748"),
        ("63_fixed_mapping_with_unused_zeros.eds", "185#0900"),
    ],
)
def test_a_tpdo_of_a_file_carries_what_it_maps(name, sent):
    assert of_file(name).send("080#") == [sent]


def test_parts_follow_each_other_across_bytes_and_the_rest_is_0(tmp_path):
    bits = mappable("2002", BOOLEAN, 1) + mappable("2003", U16, "0xABCD") + mappable("2004", U8, 3)
    bench = tpdo(tmp_path, 0x20020001, 0x20030010, 0x20040002, objects=bits)
    value = 1 | 0xABCD << 1 | 3 << 17
    assert bench.send("080#") == ["185#" + value.to_bytes(3, "little").hex().upper()]


def test_of_an_object_that_is_longer_the_low_bits_are_sent(tmp_path):
    parts = mappable("2002", U32, "0x89ABCDEF") + mappable("2003", I8, -1)
    bench = tpdo(tmp_path, 0x20020008, 0x20030004, 0x20020014, objects=parts)
    assert bench.send("080#") == ["185#EFFFDEBC"]


def test_what_an_rpdo_brings_of_an_object_is_extended_with_zeros(tmp_path):
    objects = mappable("2002", U32, "0xFFFFFFFF") + mappable("2003", I8) + mappable("2004", BOOLEAN)
    bench = rpdo(tmp_path, 0x20040001, 0x20020009, 0x20030006, objects=objects)
    bench.send("205#FFFF")
    assert [bench.sdo[index].raw for index in (0x2002, 0x2003, 0x2004)] == [0x1FF, 0x3F, True]
    bench.send("205#0204")
    assert [bench.sdo[index].raw for index in (0x2002, 0x2003, 0x2004)] == [1, 1, False]


def test_every_length_from_1_to_64_bits_goes_through(tmp_path):
    objects = "".join(entry(f"200{n}", U64) for n in (2, 3))
    received = "".join(mapping(f"16{n:02X}", 0x20020000 | n + 1) for n in range(64))
    received += "".join(record(f"14{n:02X}", (U32, 0x300 + n), (U8, 255)) for n in range(64))
    sent = "".join(mapping(f"1A{n:02X}", 0x20020000 | n + 1) for n in range(64))
    sent += "".join(record(f"18{n:02X}", (U32, 0x400 + n), (U8, 253)) for n in range(64))
    bench = started(bench_of(tmp_path, received + sent + objects))
    pattern = 0xA5C3_9F17_E86D_42B1
    for n in range(64):
        value = pattern & (1 << n + 1) - 1
        data = value.to_bytes(n // 8 + 1, "little").hex().upper()
        bench.send(f"{0x300 + n:03X}#{data}")
        assert bench.sdo[0x2002].raw == value
        bench.sdo[0x2002].raw = pattern
        assert bench.send(f"{0x400 + n:03X}#R") == [f"{0x400 + n:03X}#{data}"]


def test_the_top_bit_of_a_length_is_of_no_use(tmp_path):
    assert tpdo(tmp_path, 0x20010090).send("080#") == ["185#0900"]


def test_a_dummy_fills_bits_of_an_rpdo(tmp_path):
    bench = rpdo(tmp_path, 0x00050003, 0x20000010, old="Dummy0005=0", new="Dummy0005=1")
    bench.send("205#FFFF07")
    assert bench.sdo[0x2000].raw == 0xFFFF


def test_a_text_takes_what_comes_and_is_cut_or_filled_to_its_length(tmp_path):
    objects = mappable("2002", TEXT, "ABCDEF") + mappable("2003", OCTETS, "0102")
    parts = (0x20020020, 0x20030018)
    bench = started(bench_of(tmp_path, mapping("1600", *parts) + mapping("1A00", *parts) + objects))
    assert bench.send("080#") == ["185#41424344010200"]
    bench.send("205#61626364090807")
    assert bench.sdo[0x2002].raw == "abcd"
    assert bench.send("080#") == ["185#61626364090807"]


def test_a_text_is_mapped_in_whole_bytes(tmp_path):
    bench = bench_of(tmp_path, mappable("2002", TEXT, "ABC") + mappable("2003", DOMAIN, "0102"))
    configure(bench, "605#2300180185010080", "605#2F001A0000000000")
    assert bench.send("605#23001A010C000220") == ["585#80001A0141000406"]
    assert bench.send("605#23001A0110000320") == ["585#80001A0141000406"]  # a domain
    configure(bench, "605#23001A0108000220")


@pytest.mark.parametrize("count", [254, 255])
def test_a_file_with_a_multiplexed_pdo_has_it_off(tmp_path, count):
    section = mapping("1A00", 0x20010010).replace("DefaultValue=1\n", f"DefaultValue={count}\n", 1)
    bench = started(bench_of(tmp_path, section))
    assert bench.send("080#") == []
    assert bench.send("605#2300180185010000") == ["585#8000180130000906"]


def test_a_file_that_maps_more_than_a_frame_has_it_off(tmp_path):
    bench = tpdo(tmp_path, *[0x20010010] * 5)
    assert bench.send("605#4000180100000000") == ["585#4300180185010080"]


def test_a_record_of_texts_is_no_pdo(tmp_path):
    texts = record("1800", (TEXT, "0x185"), (TEXT, "1")) + record(
        "1400", (U32, "0x205"), (TEXT, "x")
    )
    bench = started(bench_of(tmp_path, texts))
    assert bench.send("080#") == []
    assert bench.send("205#0B00") == []
    bench.send("080#")  # a type that is no number is 0
    assert bench.sdo[0x2000].raw == 11


def test_the_mapping_is_summed_in_bits(tmp_path):
    bench = bench_of(
        tmp_path, mapping("1A00", *[0] * 9) + mappable("2002", U64) + mappable("2003", BOOLEAN)
    )
    configure(
        bench,
        "605#2300180185010080",
        "605#2F001A0000000000",
        "605#23001A013F000220",
        *(f"605#23001A0{sub}01000320" for sub in (2, 3)),
    )
    assert bench.send("605#2F001A0003000000") == ["585#80001A0042000406"]
    configure(bench, "605#2F001A0002000000")


def test_a_remapped_pdo_survives_store_and_reset(tmp_path):
    store = record("1010", (U32, 1)) + mappable("2002", U8, 0x5A)
    bench = bench_of(tmp_path, store)
    configure(
        bench,
        "605#2300180190010080",
        "605#2F001A0000000000",
        "605#23001A0108000220",
        "605#2F001A0001000000",
        "605#2300180190010000",
        "605#2310100173617665",
    )
    bench.send("000#8105")
    bench.run(0.1)
    bench.send("000#0105")
    assert bench.send("080#") == ["190#5A"]


def test_bits_are_decoded_by_their_names():
    bench = of_file("42_bits_in_a_tpdo.eds")
    bench.send("080#")
    words = Decoder([bench.twin.node]).words(bench.trace[-1].frame)
    assert words == "TPDO1 First = True, Second = True, Rest = 21"
