import pytest

from .bus import START, aborted, read

TOO_LONG, TOO_SHORT = 0x06070012, 0x06070013


@pytest.mark.spec("T-030", "T-040")
@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("605#4001100000000000", "585#4F01100000000000"),  # 1 byte
        ("605#4000200000000000", "585#4B00200090010000"),  # 2 bytes: 400 V
        ("605#4018100100000000", "585#43181001C4010000"),  # 4 bytes: 000001C4h
        ("605#2B102000E8030000", "585#6010200000000000"),
        ("605#23051000810000FF", "585#8005100030000906"),
        ("605#2305100081000000", "585#6005100000000000"),
    ],
)
def test_up_to_four_bytes_go_in_one_frame_with_the_rest_0(topcon, request_, answer):
    assert topcon.send(request_) == [answer]


@pytest.mark.spec("T-030")
@pytest.mark.parametrize("command", ["22", "2A", "2E"])
def test_a_download_need_not_say_its_size(topcon, command):
    assert topcon.send(f"605#{command}102000E803FFFF") == ["585#6010200000000000"]
    assert read(topcon, 0x2010) == ["585#4B102000E8030000"]


@pytest.mark.spec("T-031", "A-03")
@pytest.mark.parametrize(
    "request_", ["605#C610200002000000", "605#A40810007F000000", "605#A008100001000000"]
)
def test_block_transfer_is_refused(topcon, request_):
    assert topcon.send(request_) == [f"585#80{request_[6:12]}01000405"]


@pytest.mark.spec("T-034")
@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("605#4002100000000000", 0x06020000),
        ("605#2B02100000000000", 0x06020000),
        ("605#4018100500000000", 0x06090011),
        ("605#4010200100000000", 0x06090011),  # a plain variable has sub-index 0 only
        ("605#2F10200100000000", 0x06090011),
        ("605#2300100000000000", 0x06010002),
        ("605#2B20200000000000", 0x06010002),
        ("605#2F18100000000000", 0x06010002),
        ("605#E010200000000000", 0x05040001),
    ],
)
def test_what_cannot_be_is_refused_by_its_code(topcon, request_, code):
    assert aborted(topcon.send(request_))[2] == code


@pytest.mark.spec("T-035")
@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("605#2F10200001000000", TOO_SHORT),
        ("605#2710200001000000", TOO_LONG),
        ("605#2310200001000000", TOO_LONG),
        ("605#2110200003000000", TOO_LONG),
        ("605#2110200001000000", TOO_SHORT),
        ("605#2B05100080000000", TOO_SHORT),
        ("605#2F01140105020080", TOO_SHORT),
        ("605#2B01140201000000", TOO_LONG),
    ],
)
def test_a_length_that_does_not_fit_the_type_is_refused(topcon, request_, code):
    assert aborted(topcon.send(request_))[2] == code
    assert read(topcon, 0x2010) == ["585#4B10200000000000"]


@pytest.mark.spec("T-036", "A-70")
def test_there_is_one_server_on_fixed_identifiers(topcon):
    others = [can_id for can_id in range(0x580, 0x680) if can_id != 0x605]
    for can_id in others:
        assert topcon.send(f"{can_id:03X}#4000100000000000") == []
    for subindex in (0, 1, 2):
        assert aborted(topcon.send(f"605#2300120{subindex}06060000"))[2] == 0x06010002
    assert read(topcon, 0x1201) == ["585#8001120000000206"]


@pytest.mark.spec("A-70")
@pytest.mark.parametrize("length", range(8))
def test_a_request_of_less_than_eight_bytes_is_ignored(topcon, length):
    assert topcon.send("605#" + "4000100000000000"[: 2 * length]) == []


@pytest.mark.spec("A-70")
def test_a_remote_request_is_no_sdo_request(topcon):
    assert topcon.send("605#R") == []


@pytest.mark.spec("T-037")
def test_sdo_works_in_pre_operational_and_operational(topcon):
    assert read(topcon, 0x1000) == ["585#4300100000000000"]
    topcon.send(START)
    assert read(topcon, 0x1000) == ["585#4300100000000000"]


@pytest.mark.spec("T-038")
def test_the_44_objects_of_the_manual_are_there_and_no_other(topcon):
    known = {0x1000, 0x1001, 0x1003, 0x1005, 0x1008, 0x1009, 0x100A, 0x1010, 0x1014, 0x1017}
    known |= {0x1018, 0x1200, 0x2014, 0x2030, 0x2031, 0x2100}
    for first in (0x1400, 0x1600, 0x1800, 0x1A00, 0x2000, 0x2010, 0x2020):
        known |= set(range(first, first + 4))
    assert len(known) == 44
    there = {index for index in range(0x1000, 0x6000) if aborted(read(topcon, index)) is None}
    assert there == known
    assert aborted(read(topcon, 0x1011)) == (0x1011, 0, 0x06020000)
    areas = [range(0x1000), range(0x6000, 0x10000, 0x101)]
    assert not [index for area in areas for index in area if not aborted(read(topcon, index))]


@pytest.mark.spec("T-038", "A-72")
@pytest.mark.parametrize("index", [0x100C, 0x100D, 0x1011, 0x1012, 0x1015, 0x1016, 0x1019, 0x1029])
def test_what_other_devices_have_is_missing(topcon, index):
    assert aborted(read(topcon, index)) == (index, 0, 0x06020000)


@pytest.mark.spec("T-040")
def test_the_lowest_byte_goes_first_everywhere(topcon):
    topcon.send(START)
    assert topcon.send("605#2B10200034010000") == ["585#6010200000000000"]  # 0x0134
    assert topcon.sdo["Voltage reference"].raw == 0x0134
    topcon.send("205#3502")
    assert read(topcon, 0x2010) == ["585#4B10200035020000"]
    topcon.sdo["Run command"].raw = 1
    topcon.set(load="battery 100 0.1")
    topcon.run(1.0)
    assert topcon.send("185#R") == ["185#E803FEFFFFFF0300"]  # 1000, -2, -1, 0003h
    topcon.inject("error", number=0x149)
    assert topcon.sent[-1] == "085#0021034901000000"
