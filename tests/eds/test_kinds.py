"""The kinds of peculiarities, each in more than the one shape in which it was first seen."""

import struct

import pytest

from .conftest import BASE, entry

U8, U16, U32, I16, I32, REAL32, REAL64 = 5, 6, 7, 3, 4, 8, 0x11
TEXT, OCTETS, UNICODE, TIME, DIFFERENCE, DOMAIN = 9, 0xA, 0xB, 0xC, 0xD, 0xF


@pytest.mark.parametrize(
    ("data_type", "text", "value"),
    [
        (U8, "0x1F", 31),
        (U8, "017", 15),
        (U8, "255 ; all", 255),
        (U8, "255;all", 255),
        (U8, "1Fh", 31),
        (U8, "+7", 7),
        (U16, "1,0", 1),
        (U16, "1e3", 1000),
        (U32, "0xFFFFFFFFL", 0xFFFFFFFF),
        (U32, "-1", 0xFFFFFFFF),
        (I16, "0xFFFF", -1),
        (I16, "65535", -1),
        (I16, "-32768", -32768),
        (1, "true", True),
        (1, "0", False),
        (REAL32, "1.5", 1.5),
        (REAL32, "1,5", 1.5),
        (REAL32, "0x3FC00000", 1.5),
        (REAL32, "3", 3.0),
        (REAL64, "0x3FF8000000000000", 1.5),
        (REAL64, "-1e-3", -0.001),
        (TEXT, '"quoted"', "quoted"),
        (TEXT, "half; a text ; comment", "half; a text"),
        (TEXT, "'", "'"),
        (UNICODE, "Größe", "Größe"),
        (OCTETS, "0x01 0x02", b"\x01\x02"),
        (DOMAIN, "DE AD", b"\xde\xad"),
        (TIME, "2 1000", struct.pack("<LH", 1000, 2)),
        (TIME, "0x10000", b"\x00\x00\x01\x00\x00\x00"),
        (DIFFERENCE, "0 5", struct.pack("<LH", 5, 0)),
    ],
)
def test_a_default_is_what_can_only_be_meant(reading, data_type, text, value):
    assert reading(entry(0x2002, data_type, text)).value(0x2002) == value


@pytest.mark.parametrize(
    ("data_type", "text", "told"),
    [
        (U8, "256", "256 does not fit 8 bits"),
        (I16, "0x10000", "0x10000 does not fit 16 bits"),
        (U8, "many", "'many' is no number"),
        (U8, "1_0", "'1_0' is no number"),
        (OCTETS, "ABC", "'ABC' is no row of bytes of two hex digits each"),
        (REAL32, "1e99", "1e99 does not fit 32 bits"),
        (TIME, "1 2 3", "'1 2 3' is neither days and milliseconds nor a number of 48 bits"),
        (U32, "$NODEID+$NODEID", "'$NODEID+$NODEID' does not add $NODEID once"),
        (U32, "$NODEID*2", "'$NODEID*2' is no number"),
    ],
)
def test_a_default_that_means_nothing_is_told_and_is_none(reading, data_type, text, told):
    found = reading(entry(0x2002, data_type, text))
    assert found.value(0x2002) is None
    assert found.remarks == [f"drive.eds:178: [2002] DefaultValue: {told}: as if it were not there"]


@pytest.mark.parametrize(
    ("data_type", "text", "value", "told"),
    [
        (U8, "08", 8, "08 is no octal number: taken as decimal"),
        (U16, "1.5", 1, "1.5 is taken for 1"),
        (U8, "-1", 255, "-1 is taken for the bits of 0xFF"),
        (1, "7", True, "7 is taken for 1"),
        (REAL32, "1,5", 1.5, "1,5 is taken for 1.5"),
        (TEXT, "Größe", "Größe".encode("latin-1"), "'Größe' is no ASCII: sent as Latin-1"),
    ],
)
def test_a_guess_is_told(reading, data_type, text, value, told):
    found = reading(entry(0x2002, data_type, text))
    assert found.value(0x2002) == value
    assert found.remarks == [f"drive.eds:178: [2002] DefaultValue: {told}"]


@pytest.mark.parametrize(
    ("formula", "base"),
    [
        ("$NODEID", 0),
        ("0x180 + $nodeid", 0x180),
        ("$NODEID+0x200+0x80", 0x280),
        ("$NODEID-1", -1),
        ("0x200+$NODEID-0x80", 0x180),
    ],
)
def test_a_formula_has_the_node_id_anywhere(reading, formula, base):
    found = reading(old="$NODEID+0x180", new=formula)
    assert found.value(0x1800, 1) == base
    assert (found[0x1800, 1], "default") in found.eds.relative


def test_limits_may_be_formulas_and_of_floats(reading):
    limits = "LowLimit=-1,5\nHighLimit=0x3FC00000\n"
    found = reading(entry(0x2002, REAL32, "0", limits))
    assert (found[0x2002, 0].min, found[0x2002, 0].max) == (-1.5, 1.5)
    found = reading(entry(0x2002, U32, "$NODEID", "LowLimit=$NODEID\nHighLimit=$NODEID+9\n"))
    names = [name for variable, name in found.eds.relative if variable.index == 0x2002]
    assert names == ["default", "min", "max"]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-8", "cp1252", "latin-1"])
def test_text_comes_in_any_encoding_of_tools(reading, encoding):
    more = entry(0x2002, U8, 1).replace("Extra", "Größe")
    assert "Größe" in reading(more, encoding=encoding).eds.dictionary.names


@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_lines_end_as_tools_end_them(reading, end):
    assert reading(old=BASE, new=BASE.replace("\n", end)).value(0x2000) == 7


def test_case_and_blanks_matter_nowhere(reading):
    text = BASE.replace("ParameterName=", "PARAMETERNAME = ").replace("sub", "SUB")
    text = text.replace("[2000]", "  [ 2000 ]  ").replace("[1A00]", "[1a00]")
    found = reading(old=BASE, new=text)
    assert found.remarks == []
    assert "Set value" in found.eds.dictionary.names


def test_a_key_that_is_there_twice_is_told_with_both_lines(reading):
    found = reading(old="DefaultValue=7\n", new="DefaultValue=8\nDefaultValue=7\n")
    assert found.value(0x2000) == 7
    assert found.remarks == [
        "drive.eds:165: [2000] DefaultValue is there in line 164 already: what stands here holds"
    ]


@pytest.mark.parametrize("section", ["FileInfo", "DummyUsage", "Comments", "DeviceInfo"])
def test_a_section_that_is_no_object_may_be_missing(reading, section):
    head, _, rest = BASE.partition(f"[{section}]\n")
    text = head + "[" + rest.partition("\n[")[2] if rest else head
    assert reading(old=BASE, new=text).value(0x2000) == 7


def test_dummies_are_those_that_are_allowed(reading):
    dictionary = reading(old="Dummy0005=0", new="Dummy0005=1").eds.dictionary
    assert [index for index in range(1, 32) if index in dictionary.indices] == [5]


def test_without_dummy_usage_the_types_of_the_standard_fill_gaps(reading):
    head, _, rest = BASE.partition("[DummyUsage]\n")
    found = reading(old=BASE, new=head + "[" + rest.partition("\n[")[2])
    assert [index for index in range(1, 32) if index in found.eds.dictionary.indices] == [
        *range(1, 8)
    ]


@pytest.mark.parametrize(
    ("word", "access"),
    [("R", "ro"), ("w", "wo"), ("UNKNOWN", "ro"), ("", "ro"), ("RW", "rw"), ("Const", "const")],
)
def test_access_types(reading, word, access):
    more = entry(0x2002, U8, 1).replace("AccessType=rw", f"AccessType={word}")
    assert reading(more)[0x2002, 0].access_type == access


def test_gaps_in_an_array_stay_gaps(read):
    found = read("66_error_history_with_gaps.eds")
    assert [sub for sub in range(5) if (0x1003, sub) in found] == [0, 1, 3]


def test_sub_indices_without_an_object_make_a_record(reading):
    sub = entry(0x2200, U8, 3).replace("[2200]", "[2200sub2]")
    found = reading(sub)
    assert found.value(0x2200, 2) == 3
    assert found.value(0x2200, 0) == 2  # the highest there is
    assert found.remarks == [
        "drive.eds:173: [2200] is not there, but its sub-indices are: a record is made",
        "drive.eds:173: [2200] has no ParameterName: it is called 0x2200",
        "drive.eds:173: [2200] has no sub-index 0: it tells the highest there is",
    ]


@pytest.mark.parametrize("kind", [5, 7])
def test_a_type_definition_is_served_as_a_variable(reading, kind):
    more = entry(0x60, U8, 8).replace("ObjectType=0x7", f"ObjectType={kind}")
    assert reading(more).value(0x60) == 8


def test_the_type_of_an_entry_may_be_one_that_the_file_defines(reading):
    ranges = entry(0xA0, U32, 0).replace("[00A0]", "[A0]").replace("0x7", "0x5", 1)
    ranges += entry(0xA0, U32, "0x0003").replace("[00A0]", "[A0sub1]")
    found = reading(entry(0x2002, 0xA0, "-5") + ranges)
    assert found[0x2002, 0].data_type == I16
    assert found.value(0x2002) == -5


def test_compact_lists_may_have_gaps_and_names(reading):
    array = (
        "[2100]\nParameterName=Limit\nObjectType=9\nDataType=5\nAccessType=rw\nDefaultValue=1\n"
        "CompactSubObj=3\n[2100Name]\nNrOfEntries=1\n2=Second\n"
        "[2100Value]\nNrOfEntries=2\n1=10\n3=0x1E\n[2100Denotation]\nNrOfEntries=1\n3=Third\n"
    )
    found = reading(array)
    assert [found.value(0x2100, sub) for sub in range(4)] == [3, 10, 1, 30]
    assert [found[0x2100, sub].name for sub in (1, 2, 3)] == ["Limit1", "Second", "Third"]
    assert (
        found.remarks == ["drive.eds:173: [2100] is in no list of objects: it is there anyway"][:0]
    )


def test_compact_pdos_are_those_that_are_counted(reading):
    found = reading(old="NrOfTXPDO=1", new="NrOfTXPDO=6\nCompactPDO=0x13")
    assert [index for index in range(0x1800, 0x1810) if (index, 1) in found] == [
        *range(0x1800, 0x1806)
    ]
    assert [sub for sub in range(7) if (0x1801, sub) in found] == [0, 1, 2, 5]
    assert found.value(0x1801, 1) == 0x280
    assert found.value(0x1804, 1) == 0x80000000
    assert found.value(0x1A01, 0) == 0
    assert (0x1A01, 64) in found


MODULES = """[SupportedModules]
NrOfEntries=2
[M1ModuleInfo]
ProductName=Eight outputs
[M1FixedObjects]
NrOfEntries=1
1=0x2400
[M1Fixed2400]
ParameterName=Diagnosis
ObjectType=7
DataType=5
AccessType=ro
DefaultValue=4
[M1SubExtends]
NrOfEntries=1
1=0x6200
[M1SubExt6200]
ParameterName=Outputs
ObjectType=7
DataType=5
AccessType=rww
PDOMapping=1
Count=1
ObjExtend=0
[M2SubExtends]
NrOfEntries=1
1=0x6000
[M2SubExt6000]
ParameterName=Inputs
ObjectType=7
DataType=5
AccessType=ro
PDOMapping=1
Count=0;2
ObjExtend=0
"""


def test_modules_bring_their_objects(reading):
    found = reading(MODULES, modules=[1, 2, 1])
    assert found.value(0x2400) == 4
    assert [found.value(0x6200, 0), found[0x6200, 2].name] == [2, "Outputs 2"]
    assert found[0x6200, 1].access_type == "rww"
    assert [sub for sub in range(4) if (0x6000, sub) in found] == [0, 1]


@pytest.mark.parametrize(("modules", "subs"), [(4, 1), (5, 2), (8, 2), (9, 3)])
def test_modules_of_two_bits_share_a_sub_index(reading, modules, subs):
    assert reading(MODULES, modules=[2] * modules).value(0x6000, 0) == subs


def test_the_modules_of_a_dcf_are_plugged_in(reading):
    connected = "[ConnectedModules]\nNrOfEntries=2\n1=1\n2=1\n"
    assert reading(MODULES + connected, name="drive.dcf").value(0x6200, 0) == 2


def test_a_bare_coupler_says_how_modules_are_plugged_in(reading):
    found = reading(MODULES)
    assert (0x6200, 1) not in found
    assert found.remarks == [
        "drive.eds:173: [SupportedModules] is a modular coupler: without the setting"
        " modules=1,1,2 no module is plugged in"
    ]


def test_a_mapping_ends_before_a_module_that_is_missing(reading):
    old = "DefaultValue=0x20010010"
    assert reading(MODULES, old=old, new="DefaultValue=0x62000108").value(0x1A00, 0) == 0
    found = reading(MODULES, old=old, new="DefaultValue=0x62000108", modules=[1])
    assert found.value(0x1A00, 0) == 1


@pytest.mark.parametrize("flags", ["0", "1", "0x7", "", "many"])
def test_flags_for_tools_are_not_looked_at(reading, flags):
    found = reading(entry(0x2002, U8, 3, f"ObjFlags={flags}"))
    assert (found.value(0x2002), found.remarks) == (3, [])


@pytest.mark.parametrize("named", ["fw.bin", "C:\\work\\fw.bin", "/home/maker/fw.bin ; the one"])
def test_a_domain_has_the_content_of_its_upload_file(reading, tmp_path, named):
    (tmp_path / "fw.bin").write_bytes(b"\x00\x01\xff")
    found = reading(entry(0x2002, DOMAIN, "", f"UploadFile={named}\nDownloadFile=other.bin"))
    assert (found.value(0x2002), found.remarks) == (b"\x00\x01\xff", [])
    assert found.eds.files == [tmp_path / "fw.bin"]


@pytest.mark.parametrize(
    ("data_type", "default", "value", "told"),
    [
        (DOMAIN, "", None, "UploadFile 'fw.bin' is not beside this file: as if it were not said"),
        (
            DOMAIN,
            "0A",
            b"\n",
            "UploadFile 'fw.bin' is not beside this file: as if it were not said",
        ),
        (U8, "3", 3, "UploadFile is of a DOMAIN only: ignored"),
    ],
)
def test_an_upload_file_that_is_of_no_use_is_told(reading, data_type, default, value, told):
    found = reading(entry(0x2002, data_type, default, "UploadFile=..\\fw.bin"))
    assert (found.value(0x2002), found.remarks) == (value, [f"drive.eds:180: [2002] {told}"])


SERIAL = (
    "[1018sub4]\nParameterName=Serial\nObjectType=7\nDataType=7\nAccessType=ro\nDefaultValue=1\n"
    "[DeviceComissioning]\nNodeID=5\nLSS_SerialNumber={}\n"
)


@pytest.mark.parametrize(("number", "value"), [("0x1234", 0x1234), ("77", 77), ("", 1)])
def test_the_serial_number_of_a_dcf_is_that_of_the_identity(reading, number, value):
    assert reading(SERIAL.format(number), name="drive.dcf").value(0x1018, 4) == value


def test_a_serial_number_that_is_too_large_is_told(reading):
    found = reading(SERIAL.format("0x100000000"), name="drive.dcf")
    assert found.value(0x1018, 4) == 1
    assert "does not fit 32 bits: ignored" in found.remarks[-1]


@pytest.mark.parametrize(("kind", "made"), [("0x2", DOMAIN), ("2", DOMAIN)])
def test_a_domain_needs_no_data_type_and_no_access(reading, kind, made):
    found = reading(f"[2002]\nParameterName=Programme\nObjectType={kind}\n")
    assert found[0x2002, 0].data_type == made
    assert found[0x2002, 0].access_type == "rw"


def test_a_structure_that_the_file_defines_is_served_as_a_record(reading):
    struct_ = (
        "[2100]\nParameterName=Pair\nObjectType=0x6\nSubNumber=2\n"
        + entry(0x2100, U8, 1).replace("[2100]", "[2100sub0]")
        + entry(0x2100, U16, 8).replace("[2100]", "[2100sub1]")
    )
    found = reading(struct_)
    assert [found.value(0x2100, sub) for sub in (0, 1)] == [1, 8]


def test_a_name_may_have_anything_in_it(reading):
    more = entry(0x2002, U8, 1).replace("Extra", "100 %(x)s [A]=b;c")
    assert "100 %(x)s [A]=b;c" in reading(more).eds.dictionary.names
