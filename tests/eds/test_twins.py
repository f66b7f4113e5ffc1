"""Files with one peculiarity each, as twins on a bus: `tests/eds/files`, node id 5."""

import pytest

from canopen_twins import Bench, UserError

from .conftest import BASE, FILES, entry

NOT_BY_SYNC = {
    "28_pdo_without_mapping.eds",  # what its PDO does is told elsewhere
    "29_mapping_of_nothing.eds",
    "42_bits_in_a_tpdo.eds",
    "45_text_in_a_tpdo.eds",
    "63_fixed_mapping_with_unused_zeros.eds",
}
ALL = sorted(path.name for path in FILES.iterdir())


@pytest.fixture
def twin():
    """A bench with the twin of a file, at node id 5."""
    return lambda name, **settings: Bench(FILES / name, **{"node_id": 5, **settings})


@pytest.mark.parametrize("name", [name for name in ALL if name not in NOT_BY_SYNC])
def test_it_boots_and_a_sync_brings_its_actual_value(twin, name):
    bench = twin(name)
    assert bench.sent == ["705#00"]
    bench.send("000#0105")
    assert bench.send("080#") == ["185#0900"]


READ = {  # requests, and what answers
    "10_compact_array.eds": [
        ("4000210000000000", "4F00210004000000"),
        ("4000210100000000", "4F00210103000000"),
        ("4000210400000000", "4F00210403000000"),
        ("4000210500000000", "8000210511000906"),
    ],
    "12_compact_mapping_array.eds": [("40001A0100000000", "43001A0110000120")],
    "14_int32_default_as_unsigned_hex.eds": [("4002200000000000", "4302200000000080")],
    "16_default_octal.eds": [("4002200000000000", "4F02200008000000")],
    "17_default_float_for_integer.eds": [("4002200000000000", "4302200000000000")],
    "19_default_time_of_day.eds": [
        ("4002200000000000", "4102200006000000"),
        ("6000000000000000", "0300FB2482080000"),
    ],
    "21_domain_and_octet_string.eds": [
        ("4002200000000000", "470220000102FF00"),
        ("4003200000000000", "470320000102FF00"),
    ],
    "22_boolean.eds": [
        ("4002200000000000", "4F02200001000000"),
        ("2F02200000000000", "6002200000000000"),
        ("4002200000000000", "4F02200000000000"),
    ],
    "23_int24_uint40_int64.eds": [
        ("4002200000000000", "47022000FBFFFF00"),
        ("27022000FCFFFF00", "6002200000000000"),
        ("4002200000000000", "47022000FCFFFF00"),
        ("4003200000000000", "4103200005000000"),
        ("6000000000000000", "0555443322110000"),
        ("2103200005000000", "6003200000000000"),
        ("0506070809000000", "2000000000000000"),
        ("4003200000000000", "4103200005000000"),
        ("6000000000000000", "0506070809000000"),
        ("4004200000000000", "4104200008000000"),
        ("6000000000000000", "00FBFFFFFFFFFFFF"),
        ("7000000000000000", "1DFF000000000000"),
    ],
    "25_value_with_comment_behind.eds": [("4000200000000000", "4B00200007000000")],
    "26_no_error_register.eds": [("4001100000000000", "8001100000000206")],
    "33_section_twice.eds": [("4001200000000000", "4B01200009000000")],
    "35_identity_as_plain_variable.eds": [("4018100000000000", "4318100001000000")],
    "38_dcf_with_the_other_spelling.dcf": [("4000200000000000", "4B00200007000000")],
    "40_dcf_parameter_value_empty.dcf": [("4000200000000000", "4B00200007000000")],
    "46_access_type_r_and_w.eds": [("2B01200001000000", "8001200002000106")],
    "48_data_type_missing.eds": [("4002200000000000", "8002200000000206")],
    "50_vendor_data_type.eds": [("4002200000000000", "4F02200001000000")],
    "52_same_name_twice.eds": [
        ("4000200000000000", "4B00200007000000"),
        ("4002200000000000", "4B02200001000000"),
    ],
    "54_limits_of_a_signed_value_as_hex.eds": [
        ("2B022000EBFF0000", "8002200032000906"),  # -21
        ("2B022000ECFF0000", "6002200000000000"),
        ("2B02200065000000", "8002200031000906"),  # 101
        ("2B02200064000000", "6002200000000000"),
    ],
    "56_limits_upside_down.eds": [("2B02200005000000", "6002200000000000")],
    "58_low_limit_empty.eds": [("2B02200000000000", "6002200000000000")],
    "66_error_history_with_gaps.eds": [
        ("4003100000000000", "4F03100000000000"),
        ("4003100200000000", "8003100211000906"),
        ("4003100300000000", "4303100300000000"),
    ],
}


@pytest.mark.parametrize("name", READ)
def test_an_object_reads_and_takes_what_the_file_says(twin, name):
    bench = twin(name)
    for request, answer in READ[name]:
        assert bench.send(f"605#{request}") == [f"585#{answer}"], request


@pytest.mark.parametrize("name", ["37_dcf_with_node_id.dcf", "38_dcf_with_the_other_spelling.dcf"])
def test_the_node_id_of_a_dcf_holds_unless_another_is_given(name):
    assert Bench(FILES / name).sent == ["710#00"]
    assert Bench(FILES / name, node_id=5).sent == ["705#00"]


def test_a_heartbeat_that_a_dcf_configures_is_sent(twin):
    assert twin("41_dcf_heartbeat.dcf").run(0.25) == ["705#7F"]


def test_what_a_dcf_configures_is_there_again_after_a_reset(twin):
    bench = twin("41_dcf_heartbeat.dcf")
    assert bench.send("000#8105") == ["705#00"]
    assert bench.run(0.25) == ["705#7F"]


@pytest.mark.parametrize("identifier", ["185", "205"])
def test_a_node_id_behind_and_in_lower_case_counts(twin, identifier):
    bench = twin("24_node_id_behind_and_in_lower_case.eds")
    index = {"185": "0018", "205": "0014"}[identifier]
    answer = f"585#43{index}01{int(identifier, 16).to_bytes(4, 'little').hex().upper()}"
    assert bench.send(f"605#40{index}0100000000") == [answer]


def test_names_have_their_umlauts(twin):
    assert "Verzögerung" in twin("08_umlaut_in_a_name_latin1.eds").values()


def test_what_was_written_is_in_the_rpdo_too(twin):
    bench = twin("00_base.eds")
    bench.send("000#0105")
    bench.send("205#3412")
    assert bench.send("605#4000200000000000") == ["585#4B00200034120000"]


def test_a_name_of_two_objects_is_said_to_be_one_when_it_is_used(twin):
    bench = twin("52_same_name_twice.eds")
    told = "'Set value' is the name of 0x2000:00 and 0x2002:00: say which by its address"
    with pytest.raises(UserError) as refusal:
        bench.values("Set value")
    assert str(refusal.value) == told
    with pytest.raises(KeyError, match="0x2000 and 0x2002"):
        _ = bench.sdo["Set value"]
    with pytest.raises(UserError) as refusal:
        bench.inject("sdo_abort", object="Set value")
    assert str(refusal.value) == told
    assert bench.values("0x2002:00", "Actual value") == {"0x2002:00": 1, "Actual value": 9}
    assert {"0x2000:00": 7, "0x2002:00": 1}.items() <= bench.values().items()


@pytest.fixture
def twin_of(tmp_path):
    """A bench with the twin of the base file with sections behind it."""

    def make(more):
        (tmp_path / "drive.eds").write_text(BASE + more)
        return Bench(tmp_path / "drive.eds", node_id=5)

    return make


REAL32, DOMAIN = 8, 0xF


def test_limits_of_a_float_count(twin_of):
    bench = twin_of(entry(0x2002, REAL32, "1,5", "LowLimit=-1.5\nHighLimit=2.5"))
    assert bench.send("605#4002200000000000") == ["585#430220000000C03F"]
    assert bench.send("605#2302200000002040") == ["585#6002200000000000"]  # 2.5
    assert bench.send("605#2302200000004040") == ["585#8002200031000906"]  # 3.0
    assert bench.send("605#23022000000000C0") == ["585#8002200032000906"]  # -2.0


def test_a_domain_is_read_from_its_upload_file_and_written_in_memory(twin_of, tmp_path):
    content = bytes(range(256)) * 40
    (tmp_path / "fw.bin").write_bytes(content)
    bench = twin_of(entry(0x2200, DOMAIN, "", "UploadFile=fw.bin"))
    assert bench.sdo.upload(0x2200, 0) == content
    with bench.sdo[0x2200].open("rb", block_transfer=True) as file:
        assert file.read() == content
    bench.sdo.download(0x2200, 0, b"other")
    assert bench.sdo.upload(0x2200, 0) == b"other"
    assert (tmp_path / "fw.bin").read_bytes() == content
