import csv
from collections import Counter

import canopen
import pytest
from canopen.objectdictionary.datatypes import INTEGER16, UNSIGNED16, UNSIGNED32

from canopen_twins.files.shipped import od_file

NODE_ID = 29
PLAIN = {0x1000, 0x1001, 0x1005, 0x1008, 0x1009, 0x100A, 0x1014, 0x1017}
SEVERAL_ENTRIES = {0x1003: 17, 0x1010: 2, 0x1018: 5, 0x1200: 3, 0x2100: 3}
PDO_COMMUNICATION = {0x1400 + n: 3 for n in range(4)} | {0x1800 + n: 3 for n in range(4)}
MAPPINGS = {0x1600: 2, 0x1601: 2, 0x1602: 3, 0x1603: 2}
MAPPINGS |= {0x1A00: 5, 0x1A01: 1, 0x1A02: 1, 0x1A03: 1}
PROCESS = [  # name, type, access, low limit, high limit, mapped: Tab. 45 to 62
    (0x2000, "Nominal voltage", INTEGER16, "ro", None, None, False),
    (0x2001, "Maximum current", INTEGER16, "ro", None, None, False),
    (0x2002, "Nominal power", INTEGER16, "ro", None, None, False),
    (0x2003, "Nominal internal resistance", INTEGER16, "ro", None, None, False),
    (0x2010, "Voltage reference", INTEGER16, "rw", 0, 4000, True),
    (0x2011, "Current reference", INTEGER16, "rw", 0, 4000, True),
    (0x2012, "Power reference", INTEGER16, "rw", 0, 4000, True),
    (0x2013, "Internal resistance reference", INTEGER16, "rw", 0, 4000, True),
    (0x2014, "Run command", UNSIGNED16, "rw", None, None, True),
    (0x2020, "Actual voltage", INTEGER16, "ro", None, None, True),
    (0x2021, "Actual current", INTEGER16, "ro", None, None, True),
    (0x2022, "Actual power", INTEGER16, "ro", None, None, True),
    (0x2023, "State of output", UNSIGNED16, "ro", None, None, True),
    (0x2030, "Overvoltage level", UNSIGNED16, "rw", 0, 4400, False),
    (0x2031, "Overcurrent level", UNSIGNED16, "rw", 0, 4400, False),
]
NUMBERED = {0x2100: 6, 0x2200: 9, 0x2300: 10, 0x3100: 5, 0x3200: 26, 0x3300: 5, 0x4200: 9}
NUMBERED |= {0x5000: 51, 0x6100: 49, 0x7000: 37, 0x8100: 30, 0x9000: 4, 0xF000: 13, 0xFF00: 257}
WITHOUT_NUMBER = [0x0000, 0x5000, 0x8110, 0x8111, 0x8112, 0x8200]
FAMILIES = {0x2: 0x03, 0x3: 0x05, 0x4: 0x09, 0x8: 0x11}  # current, voltage, temperature, bus
OTHER_FAMILIES = 0x81


def load(node_id=NODE_ID):
    with od_file("topcon.eds") as path:
        return canopen.import_od(str(path), node_id)


@pytest.fixture(scope="module")
def od():
    return load()


@pytest.fixture(scope="module")
def messages():
    with od_file("topcon_emcy.csv") as path, path.open(encoding="ascii", newline="") as file:
        return [
            (int(row["code"], 16), int(row["register"], 16), int(row["detail"], 16), row["label"])
            for row in csv.DictReader(file, strict=True)
        ]


def entries(item):
    return getattr(item, "subindices", {0: item})


def values(item):
    return [entry.default for entry in entries(item).values()]


def access(item):
    return " ".join(entry.access_type for entry in entries(item).values())


def on_the_wire(code, register, detail):
    return code.to_bytes(2, "little") + bytes([register]) + detail.to_bytes(5, "little")


@pytest.mark.spec("T-038")
def test_the_dictionary_has_the_44_objects_of_the_manual_with_94_entries(od):
    sizes = dict.fromkeys([*PLAIN, *(row[0] for row in PROCESS)], 1)
    sizes |= SEVERAL_ENTRIES | PDO_COMMUNICATION | MAPPINGS
    assert {index: len(entries(item)) for index, item in od.items()} == sizes
    assert (len(sizes), sum(sizes.values())) == (44, 94)


def test_the_bit_rates_are_those_of_the_rotary_switch(od):
    rates = {10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000}
    assert od.device_information.allowed_baudrates == rates


@pytest.mark.parametrize("row", PROCESS, ids=lambda row: f"{row[0]:04X}")
def test_the_process_objects_are_those_of_chapter_7_3(od, row):
    index, *printed = row
    entry = od[index]
    limits = [entry.min, entry.max]
    mapped = entry.pdo_mappable
    assert [entry.name, entry.data_type, entry.access_type, *limits, mapped] == printed
    assert entry.default is None


@pytest.mark.spec("T-100")
def test_no_device_profile(od):
    assert (values(od[0x1000]), access(od[0x1000])) == ([0], "ro")


@pytest.mark.spec("T-106")
def test_the_names_of_the_device(od):
    strings = [od[index] for index in (0x1008, 0x1009, 0x100A)]
    assert [string.default for string in strings] == ["TopCon Quadro", "V4.x", "V4.11.45"]
    assert [access(string) for string in strings] == ["ro", "ro", "ro"]


@pytest.mark.spec("T-110", "T-113", "T-115", "T-120", "T-140")
@pytest.mark.parametrize("node_id", [1, 29, 127])
def test_the_identifiers_follow_the_node_id(node_id):
    od = load(node_id)
    assert (values(od[0x1005]), access(od[0x1005])) == ([0x80], "rw")
    assert (values(od[0x1014]), access(od[0x1014])) == ([0x80 + node_id], "ro")
    assert values(od[0x1200]) == [2, 0x600 + node_id, 0x580 + node_id]
    assert access(od[0x1200]) == "ro ro ro"
    received = [values(od[index]) for index in range(0x1400, 0x1404)]
    assert received == [[2, 0x40000000 + n * 0x100 + node_id, 254] for n in (2, 3, 4, 5)]
    sent = [values(od[index]) for index in range(0x1800, 0x1804)]
    bases = [0x180, 0x80000280, 0x80000380, 0x80000480]
    assert sent == [[2, base + node_id, 253] for base in bases]
    assert {access(od[index]) for index in PDO_COMMUNICATION} == {"ro rw rw"}


@pytest.mark.spec("T-114")
def test_the_identity_object(od):
    assert values(od[0x1018]) == [4, 0x1C4, 0, 9, 1]
    assert access(od[0x1018]) == "ro ro ro ro ro"


def test_what_can_be_written_besides_set_values_and_identifiers(od):
    assert (values(od[0x1003]), access(od[0x1003])) == ([0] + [None] * 16, "rw" + " ro" * 16)
    assert (values(od[0x1010]), access(od[0x1010])) == ([1, 1], "ro rw")
    assert od[0x1010][1].data_type == UNSIGNED32
    assert (values(od[0x1017]), access(od[0x1017])) == ([0], "rw")
    assert (values(od[0x2100]), access(od[0x2100])) == ([2, 0, None], "ro rw rw")


@pytest.mark.spec("T-130", "T-131", "T-150")
def test_the_mapping_is_fixed(od):
    assert {entry.access_type for index in MAPPINGS for entry in entries(od[index]).values()} == {
        "ro"
    }
    assert [values(od[index]) for index in MAPPINGS] == [
        [1, 0x20100010],
        [1, 0x20110010],
        [2, 0x20120010, 0x20130010],
        [1, 0x20140010],
        [4, 0x20200010, 0x20210010, 0x20220010, 0x20230010],
        [0],
        [0],
        [0],
    ]


@pytest.mark.spec("T-057")
def test_517_messages_under_19_codes(messages):
    counts = Counter(code for code, *_ in messages)
    assert counts == Counter(NUMBERED) + Counter(WITHOUT_NUMBER)
    assert (len(messages), len(counts)) == (517, 19)


@pytest.mark.spec("T-057")
def test_an_error_number_has_one_code_and_six_codes_come_without_a_number(messages):
    pairs = [(code, detail) for code, _, detail, _ in messages]
    assert [code for code, detail in pairs if not detail and code != 0x6100] == WITHOUT_NUMBER
    numbers = sorted(detail for code, detail in pairs if detail or code == 0x6100)
    assert numbers == [number for number in range(0x200) if number != 0x14D]


def test_the_error_register_goes_with_the_code(messages):
    for code, register, detail, _ in messages:
        if code == 0:
            assert register == 0
        elif (code, detail) == (0x5000, 0):  # Tab. 72: the one hardware error with the lone bit 0
            assert register == 0x01
        else:
            assert register == FAMILIES.get(code >> 12, OTHER_FAMILIES), hex(detail)


@pytest.mark.spec("T-052", "T-053")
def test_the_printed_bytes(messages):
    wire = {label: on_the_wire(*message) for *message, label in messages}
    assert wire["gate driver A fault"] == bytes.fromhex("0023032300000000")
    assert wire["no error or errors reset"] == bytes(8)


@pytest.mark.spec("T-059")
def test_the_last_three_bytes_are_always_zero(messages):
    assert {on_the_wire(*message)[5:] for *message, _ in messages} == {bytes(3)}


def test_every_message_has_a_short_label_and_the_unexplained_ones_their_number(messages):
    for code, _, detail, label in messages:
        assert 0 < len(label) <= 64
        assert (label == f"device-specific error {detail:03X}") == (code == 0xFF00)
