import pytest
from canopen.objectdictionary.datatypes import VISIBLE_STRING
from charger_bus import ENTER_PREOP, START, aborted, ask, refused, value

from canopen_twins import Bench

SIZED = {1: "2F", 2: "2B", 4: "23"}


def address(index, subindex=0):
    return f"{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}"


@pytest.mark.spec("C-001")
def test_the_services_are_those_of_the_dictionary(bench):
    assert bench.run(1.0) == ["763#7F"]  # heartbeat producer
    bench.inject("error", key="hardware")
    assert bench.sent[-1].startswith("0E3#")  # EMCY producer
    assert ask(bench, 0x1000) == ["5E3#4300100091010000"]  # SDO server
    assert len(bench.send(START)) == 3  # TPDOs
    bench.send("7E5#0401000000000000")  # LSS slave
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E63000000000000"]
    bench.send("263#00")  # RPDO
    assert bench.send("000#8163") == ["763#00", "0E3#005001010B000000"]  # NMT slave


@pytest.mark.spec("C-002")
def test_nothing_else_is_there(bench):
    missing = [0x1005, 0x1006, 0x1007, 0x100C, 0x100D, 0x1012, 0x1016, 0x1280, 0x1401, 0x1803]
    for index in [*missing, 0x1A03, 0x2004, 0x6001, 0x1029]:
        assert aborted(ask(bench, index)) == (index, 0, 0x06020000)
    bench.send(START)
    for frame in ("080#", "100#00000000", "763#R", "6E3#4000100000000000", "6E4#05"):
        assert bench.send(frame) == []


@pytest.mark.spec("C-070")
def test_the_identifiers_can_be_read(bench):
    assert [value(bench, sub, 0x1200) for sub in (1, 2)] == [0x663, 0x5E3]
    assert bench.send("662#4000100000000000") == []
    with refused(0x06010002):
        bench.sdo[0x1200][1].raw = 0x664


@pytest.mark.spec("C-071", "C-073")
@pytest.mark.parametrize(
    ("index", "subindex", "answer"),
    [
        (0x1000, 0, "43 00 10 00 91 01 00 00"),
        (0x2002, 0x11, "4B 02 20 11 F4 01 00 00"),
        (0x2002, 0x06, "4F 02 20 06 63 00 00 00"),
        (0x1008, 0, "43 08 10 00 50 43 53 43"),
        (0x100A, 0, "43 0A 10 00 30 31 30 30"),
        (0x1018, 1, "43 18 10 01 4E 02 00 00"),
        (0x6401, 7, "4B 01 64 07 00 00 00 00"),
    ],
)
def test_a_value_comes_with_its_length_lowest_byte_first(bench, index, subindex, answer):
    assert ask(bench, index, subindex) == ["5E3#" + answer.replace(" ", "")]


WRITES = [(0x2002, 0x16, 1, 0x1E), (0x2002, 0x11, 2, 0x0BB8), (0x2002, 0x1A, 4, 0x00989680)]


@pytest.mark.spec("C-074", "A-03")
@pytest.mark.parametrize(("index", "subindex", "size", "new"), WRITES)
def test_22h_takes_as_many_bytes_as_the_object_has(bench, index, subindex, size, new):
    data = (new.to_bytes(size, "little") + b"\xee" * 4)[:4].hex()
    assert bench.send(f"663#22{address(index, subindex)}{data}") == [
        f"5E3#60{address(index, subindex)}00000000"
    ]
    assert value(bench, subindex, index) == new


@pytest.mark.spec("C-075", "C-076", "A-03")
@pytest.mark.parametrize(("index", "subindex", "size", "new"), WRITES)
def test_a_write_with_its_size_is_taken_and_confirmed(bench, index, subindex, size, new):
    data = new.to_bytes(size, "little").ljust(4, b"\0").hex()
    assert bench.send(f"663#{SIZED[size]}{address(index, subindex)}{data}") == [
        f"5E3#60{address(index, subindex)}00000000"
    ]
    assert value(bench, subindex, index) == new


@pytest.mark.spec("C-077", "C-079", "C-080", "A-27")
@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("40 FF 2F 00", 0x06020000),  # no object
        ("2F 05 20 00 01", 0x06020000),
        ("40 02 20 2B", 0x06090011),  # no entry
        ("40 02 20 23", 0x06090011),
        ("40 02 20 24", 0x06090011),
        ("40 00 10 05", 0x06090011),
        ("2B 02 20 24 01", 0x06090011),
        ("23 00 10 00 91 01 00 00", 0x06010002),  # read only
        ("22 08 10 00 41 41 41 41", 0x06010002),
        ("2B 02 20 0A 01", 0x06010002),
        ("2F 02 20 05 01", 0x06010002),
        ("40 00 62 01", 0x06010001),  # write only
        ("40 03 20 01", 0x06010001),
        ("2B 02 20 11 11 27", 0x06090031),  # 10001 ms
        ("2B 02 20 11 63 00", 0x06090032),  # 99 ms
        ("2F 02 20 02 20", 0x06090031),
        ("2F 02 20 07 05", 0x06090030),  # no such bit timing
        ("2F 00 62 01 01", 0x06090030),
        ("23 02 20 11 E8 03", 0x06070012),  # four bytes for two
        ("2F 02 20 11 E8", 0x06070013),
        ("2B 02 20 16 1E", 0x06070012),
    ],
)
def test_every_refusal_has_its_code_and_changes_nothing(bench, request_, code):
    data = request_.replace(" ", "").ljust(16, "0")
    before = [value(bench, sub) for sub in (0x02, 0x07, 0x11, 0x16)]
    assert bench.send(f"663#{data}") == [f"5E3#80{data[2:8]}{code.to_bytes(4, 'little').hex()}"]
    assert [value(bench, sub) for sub in (0x02, 0x07, 0x11, 0x16)] == before


@pytest.mark.spec("C-078")
@pytest.mark.parametrize("target", ["021116", "081000", "001000", "FF2F00"])
@pytest.mark.parametrize("command", ["20", "21", "A0", "A4", "C0", "C2"])
def test_segmented_and_block_transfers_are_not_opened(bench, command, target):
    frame = f"663#{command}{target}07000000"
    assert bench.send(frame) == [f"5E3#80{target}01000405"]


@pytest.mark.spec("C-078", "A-27")
@pytest.mark.parametrize("command", ["00", "10", "60", "70", "A1", "A3", "C1", "E0"])
def test_a_segment_of_no_transfer_and_an_unknown_command_are_about_no_object(bench, command):
    frame = f"663#{command}02111607000000"
    assert bench.send(frame) == ["5E3#8000000001000405"]


@pytest.mark.spec("C-078")
def test_nothing_is_open_after_a_refused_transfer(bench):
    bench.send("663#2108100004000000")
    assert bench.send("663#0041414141414141") == ["5E3#8000000001000405"]
    assert ask(bench, 0x1000) == ["5E3#4300100091010000"]
    assert bench.run(30.0) == ["763#7F"] * 30


@pytest.mark.spec("C-072", "A-27")
@pytest.mark.parametrize("command", [*range(0x80), *range(0xA0, 0x100)])
def test_every_request_is_answered_once(bench, command):
    (answer,) = bench.send(f"663#{command:02X}0220110B00AABB")
    assert answer.startswith("5E3#")
    assert len(answer) == len("5E3#") + 16


@pytest.mark.spec("C-072", "A-27")
@pytest.mark.parametrize(
    "frame", ["663#", "663#40", "663#4000100000", "663#40001000000000", "663#8002201100000405"]
)
def test_short_frames_and_aborts_of_the_client_are_not(bench, frame):
    assert bench.send(frame) == []
    assert bench.run(0.9) == []


@pytest.mark.spec("C-081")
@pytest.mark.parametrize("variant", ["base", "A", "C"])
@pytest.mark.parametrize("state", [ENTER_PREOP, START])
def test_every_entry_is_reached_in_both_states(variant, state):
    bench = Bench("charger", variant=variant)
    bench.send(state)
    for item in bench.device.dictionary().values():
        if item.index < 0x1000:
            continue
        for variable in getattr(item, "subindices", {0: item}).values():
            answer = ask(bench, variable.index, variable.subindex)
            if variable.access_type == "wo":
                assert aborted(answer)[2] == 0x06010001
            else:
                size = 4 if variable.data_type == VISIBLE_STRING else len(variable) // 8
                assert answer[0][4:6] == {4: "43", 2: "4B", 1: "4F"}[size], variable


@pytest.mark.spec("C-110", "C-111", "C-112", "C-113", "A-06", "A-33")
def test_it_says_which_one_it_is():
    bench = Bench(
        "charger", kind="PCTL", firmware="0213", product_code=7, revision=8, serial=0xFFFFFFFF
    )
    names = [bytes(bench.sdo.upload(index, 0)) for index in (0x1008, 0x100A)]
    assert names == [b"PCTL", b"0213"]
    assert [value(bench, sub, 0x1018) for sub in range(5)] == [4, 0x24E, 7, 8, 0xFFFFFFFF]
    assert bench.sdo[0x1000].raw == 0x191


@pytest.mark.spec("C-121", "A-67")
def test_the_burn_in_is_over(bench):
    assert value(bench, 0x05) == 1
    with refused(0x06010002):
        bench.sdo[0x2002][0x05].raw = 0


@pytest.mark.spec("C-154", "C-155", "A-55")
def test_limits_that_are_other_entries_hold_at_the_moment_of_the_write(bench):
    for subindex, wrong, code in ((0x08, 1499, 0x06090032), (0x08, 30_001, 0x06090031)):
        with refused(code):
            bench.sdo[0x2002][subindex].raw = wrong
    bench.sdo[0x2002][0x0D].raw = 20_000
    with refused(0x06090031):
        bench.sdo[0x2002][0x08].raw = 20_001
    bench.sdo[0x2002][0x08].raw = 20_000
    bench.sdo[0x2002][0x0D].raw = 10_000
    assert value(bench, 0x08) == 10_000
    with refused(0x06090031):
        bench.sdo[0x2002][0x0C].raw = 10_001
    with refused(0x06090032):
        bench.sdo[0x2002][0x0D].raw = 1499
    with refused(0x06090032):
        bench.sdo[0x2002][0x0E].raw = 249
