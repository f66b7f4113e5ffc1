"""Files with one peculiarity each: what comes out is what the tool that wrote it meant."""

import pytest

from canopen_twins.errors import UserError
from canopen_twins.files.sections import decoded
from canopen_twins.slave.eds.reader import read_eds

from .conftest import FILES

NO_REMARK = [
    "00_base.eds",
    "04_pdo_mapping_empty.eds",
    "05_comments_line_in_lower_case.eds",
    "07_windows_1252.eds",
    "08_umlaut_in_a_name_latin1.eds",
    "10_compact_array.eds",
    "12_compact_mapping_array.eds",
    "14_int32_default_as_unsigned_hex.eds",
    "16_default_octal.eds",
    "17_default_float_for_integer.eds",
    "24_node_id_behind_and_in_lower_case.eds",
    "25_value_with_comment_behind.eds",
    "31_sub_before_its_parent.eds",
    "40_dcf_parameter_value_empty.dcf",
    "53_name_with_percent.eds",
    "57_crlf.eds",
    "58_low_limit_empty.eds",
]


@pytest.mark.parametrize("name", sorted(path.name for path in FILES.iterdir()))
def test_every_file_is_a_dictionary_with_a_set_value_and_an_actual_value(read, name):
    found = read(name)
    assert found.value(0x2000) == 7
    assert found.value(0x2001) == 9


@pytest.mark.parametrize("name", NO_REMARK)
def test_what_can_only_mean_one_thing_is_no_remark(read, name):
    assert read(name).remarks == []


def test_an_empty_number_of_device_info_is_told_with_its_line(read):
    assert read("01_device_info_number_empty.eds").remarks == [
        "01_device_info_number_empty.eds:14: [DeviceInfo] ProductNumber is empty:"
        " as if it were not there"
    ]


def test_a_padded_number_is_decimal(read):
    information = read("02_device_info_number_with_leading_zeros.eds").eds.dictionary
    assert information.device_information.vendor_number == 1


def test_no_byte_of_a_file_is_lost():
    left_open = {0x81, 0x8D, 0x8F, 0x90, 0x9D}  # by Windows-1252
    for byte in range(0x80, 0x100):
        encoding = "latin-1" if byte in left_open else "cp1252"
        assert decoded(b"a%c" % byte) == "a" + bytes([byte]).decode(encoding)


def test_umlauts_are_there_whatever_wrote_them(read):
    windows = getattr(read("07_windows_1252.eds").eds.dictionary, "__edsFileInfo")
    assert windows["Description"] == "Drehzähler „X”"
    assert "Verzögerung" in read("08_umlaut_in_a_name_latin1.eds").eds.dictionary.names


def test_a_compact_array_has_as_many_entries_as_it_says(read):
    found = read("10_compact_array.eds")
    assert [found.value(0x2100, sub) for sub in range(5)] == [4, 3, 3, 3, 3]
    assert (0x2100, 5) not in found
    assert [found[0x2100, sub].name for sub in (0, 1, 4)] == ["NrOfObjects", "Inputs1", "Inputs4"]


def test_a_compact_array_takes_the_values_of_its_list(read):
    found = read("12_compact_mapping_array.eds")
    assert [found.value(0x1A00, sub) for sub in (0, 1)] == [1, 0x20010010]


@pytest.mark.parametrize(
    ("name", "index", "value"),
    [
        ("14_int32_default_as_unsigned_hex.eds", 0x2002, -0x80000000),
        ("16_default_octal.eds", 0x2002, 8),
        ("17_default_float_for_integer.eds", 0x2002, 0),
        ("19_default_time_of_day.eds", 0x2002, (36543200000).to_bytes(6, "little")),
        ("21_domain_and_octet_string.eds", 0x2002, b"\x01\x02\xff"),
        ("21_domain_and_octet_string.eds", 0x2003, b"\x01\x02\xff"),
        ("22_boolean.eds", 0x2002, True),
        ("23_int24_uint40_int64.eds", 0x2002, -5),
        ("23_int24_uint40_int64.eds", 0x2003, 0x1122334455),
        ("23_int24_uint40_int64.eds", 0x2004, -5),
        ("25_value_with_comment_behind.eds", 0x2000, 7),
        ("50_vendor_data_type.eds", 0x2002, b"\x01"),
    ],
)
def test_a_value_is_what_its_type_makes_of_the_text(read, name, index, value):
    assert read(name).value(index) == value


@pytest.mark.parametrize("index", [0x1400, 0x1800])
def test_the_node_id_counts_on_either_side_and_in_any_case(read, index):
    found = read("24_node_id_behind_and_in_lower_case.eds")
    assert (found[index, 1], "default") in found.eds.relative
    assert found.value(index, 1) == {0x1400: 0x200, 0x1800: 0x180}[index]


def test_a_pdo_without_mapping_is_told(read):
    assert read("28_pdo_without_mapping.eds").remarks == [
        "28_pdo_without_mapping.eds:116: [1800] TPDO1 has no mapping 0x1A00: there is no such PDO"
    ]


def test_a_mapping_of_nothing_is_told(read):
    assert read("29_mapping_of_nothing.eds").remarks == [
        "29_mapping_of_nothing.eds:141: [1A00] TPDO1 maps 0x2777:00, which is not there:"
        " the PDO cannot become valid"
    ]


def test_a_section_that_is_there_twice_is_told_with_both_lines(read):
    assert read("33_section_twice.eds").remarks == [
        "33_section_twice.eds:173: [2001] is there in line 166 already: what stands here holds"
    ]


@pytest.mark.parametrize("name", ["37_dcf_with_node_id.dcf", "38_dcf_with_the_other_spelling.dcf"])
def test_a_dcf_brings_its_node_id_and_bit_rate(read, name):
    eds = read(name).eds
    assert (eds.node_id, eds.node_name, eds.dictionary.bitrate) == (16, "sixteen", 500_000)


def test_a_parameter_value_stands_above_the_default_unless_it_is_empty(read):
    assert read("40_dcf_parameter_value_empty.dcf").value(0x2000) == 7
    assert read("41_dcf_heartbeat.dcf").value(0x1017) == 200


def test_access_in_one_letter_is_told(read):
    found = read("46_access_type_r_and_w.eds")
    assert found[0x2001, 0].access_type == "ro"
    assert "46_access_type_r_and_w.eds:170: [2001] AccessType 'R' is taken for ro" in found.remarks


def test_an_entry_without_a_type_is_left_out(read):
    found = read("48_data_type_missing.eds")
    assert (0x2002, 0) not in found
    assert found.remarks == ["48_data_type_missing.eds:173: [2002] has no DataType: left out"]


def test_a_type_of_a_maker_is_told(read):
    assert read("50_vendor_data_type.eds").remarks == [
        "50_vendor_data_type.eds:176: [2002] data type 0x0040 is none of CiA 301:"
        " served as the bytes it has"
    ]


def test_a_name_of_two_objects_stands_for_neither(read):
    dictionary = read("52_same_name_twice.eds").eds.dictionary
    with pytest.raises(KeyError, match="is the name of 0x2000 and 0x2002: say which by its index"):
        dictionary["Set value"]
    assert [dictionary[index].default for index in (0x2000, 0x2002)] == [7, 1]


def test_limits_of_a_signed_value_are_its_bits(read):
    variable = read("54_limits_of_a_signed_value_as_hex.eds")[0x2002, 0]
    assert (variable.min, variable.max) == (-20, 100)


@pytest.mark.parametrize("name", ["56_limits_upside_down.eds", "58_low_limit_empty.eds"])
def test_limits_that_are_none(read, name):
    variable = read(name)[0x2002, 0]
    assert (variable.min, variable.max) == (None, None)


def test_what_is_no_dictionary_is_refused(tmp_path):
    for content in (b"", b"hello", b"[FileInfo]\nFileName=x\n", b"\x00\x01", b"<a/>"):
        path = tmp_path / "drive.eds"
        path.write_bytes(content)
        with pytest.raises(UserError, match=r"drive\.eds"):
            read_eds(path)
