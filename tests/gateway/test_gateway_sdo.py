import pytest

from .bus import RESET_NODE, START, STOP, read

NO_OBJECT, NO_SUBINDEX, COMMAND = 0x06020000, 0x06090011, 0x05040001
TOO_LONG, TOO_SHORT, READ_ONLY = 0x06070012, 0x06070013, 0x06010002


def aborted(bench, request):
    """The abort code a request of eight bytes gets, and whose it is."""
    (answer,) = bench.send(f"601#{request}")
    assert answer.startswith("581#80")
    assert answer[6:12] == request[2:8].upper()
    return int.from_bytes(bytes.fromhex(answer[12:]), "little")


@pytest.mark.spec("G-080", "G-081", "G-056", "G-084")
@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("4000100000000000", "4300100000000000"),
        ("4001100000000000", "4F01100000000000"),
        ("4017100000000000", "4B171000E8030000"),
        ("4018100161000000", "4318100161010000"),
        ("4018100300000000", "4318100300000000"),
        ("4000200100000000", "4B00200160080000"),
        ("4000140400000000", "4F00140400000000"),
    ],
)
def test_values_are_read_in_one_frame_of_eight_bytes(bench, request_, answer):
    assert bench.send(f"601#{request_}") == [f"581#{answer}"]


@pytest.mark.spec("G-084")
def test_no_object_has_more_than_four_bytes(bench):
    entries = bench.twin.node.slave.entries
    assert {entry.size for subs in entries.values() for entry in subs.values()} == {1, 2, 4}


@pytest.mark.spec("G-082", "G-003")
@pytest.mark.parametrize(
    "index", [0x1003, 0x1005, 0x1008, 0x100C, 0x100D, 0x1010, 0x1011, 0x1014, 0x2006, 0x0006]
)
@pytest.mark.parametrize("command", ["40", "2F", "23", "21"])
def test_an_object_that_is_not_there(bench, index, command):
    request = f"{command}{index & 0xFF:02X}{index >> 8:02X}0000000000"
    assert aborted(bench, request) == NO_OBJECT


@pytest.mark.spec("G-083", "G-051")
@pytest.mark.parametrize(
    ("index", "subindex"),
    [(0x1018, 5), (0x1018, 9), (0x1000, 1), (0x2005, 1), (0x2000, 7), (0x1600, 4), (0x2001, 5)],
)
@pytest.mark.parametrize("command", ["40", "2B", "21"])
def test_an_entry_that_is_not_there(bench, index, subindex, command):
    request = f"{command}{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}00000000"
    assert aborted(bench, request) == NO_SUBINDEX


@pytest.mark.spec("G-085", "G-086", "G-087", "G-088", "G-089")
@pytest.mark.parametrize(
    ("command", "data", "code"),
    [
        ("2F", "00000000", TOO_SHORT),  # 1017h has two bytes
        ("2B", "E8030000", READ_ONLY),
        ("27", "00000000", TOO_LONG),
        ("23", "00000000", TOO_LONG),
        ("22", "00000000", READ_ONLY),  # without a size
        ("20", "00000000", READ_ONLY),
        ("21", "01000000", TOO_SHORT),  # size in bytes 5 to 8
        ("21", "02000000", READ_ONLY),
        ("21", "03000000", TOO_LONG),
        ("21", "00000001", TOO_LONG),
    ],
)
def test_a_write_is_checked_for_its_length_and_then_refused(bench, command, data, code):
    assert aborted(bench, f"{command}171000{data}") == code


@pytest.mark.spec("G-086")
def test_what_is_not_there_comes_before_a_wrong_length(bench):
    assert aborted(bench, "2303100000000000") == NO_OBJECT
    assert aborted(bench, "2318100900000000") == NO_SUBINDEX


@pytest.mark.spec("G-085", "G-090")
def test_no_write_changes_anything(bench):
    entries = bench.twin.node.slave.entries
    for index, subs in entries.items():
        for sub, entry in subs.items():
            before = entry.read()
            assert aborted(bench, f"22{index & 0xFF:02X}{index >> 8:02X}{sub:02X}FFFFFFFF") == (
                READ_ONLY
            )
            assert entry.read() == before


@pytest.mark.spec("G-091", "G-092", "G-093")
@pytest.mark.parametrize(
    "command", [byte for byte in range(256) if byte not in (*range(0x20, 0x30), 0x40, 0x80)]
)
def test_every_other_command_is_unknown(bench, command):
    assert aborted(bench, f"{command:02X}17100001020304") == COMMAND


@pytest.mark.spec("G-094")
def test_an_abort_of_the_client_gets_no_answer(bench):
    assert bench.send("601#8017100000000405") == []
    assert read(bench, 0x1017) == 1000


@pytest.mark.spec("G-095", "G-015")
def test_requests_are_answered_in_two_states(bench):
    bench.send(START)
    assert read(bench, 0x1017) == 1000
    bench.send(STOP)
    assert bench.send("601#4017100000000000") == []
    bench.send(RESET_NODE)
    assert bench.send("601#4017100000000000") == []


@pytest.mark.spec("G-080")
@pytest.mark.parametrize(
    "request_", ["601#40171000", "601#401710000000", "601#R8", "00000601#40171000"]
)
def test_what_is_no_request_is_ignored(bench, request_):
    assert bench.send(request_ + "00000000" if request_.startswith("0000") else request_) == []
