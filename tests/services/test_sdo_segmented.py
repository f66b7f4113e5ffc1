import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from probe import Probe

from canopen_twins import Bench
from canopen_twins.slave.object import Abort

READ_NAME = "605#4008100000000000"
TEXT, DOMAIN = "052000", "062000"


def abort(multiplexer, code):
    return f"585#80{multiplexer}{code.to_bytes(4, 'little').hex().upper()}"


def send(bench, *frames):
    """The answers to several requests, without their common identifier."""
    return [
        answer.removeprefix("585#") for frame in frames for answer in bench.send(f"605#{frame}")
    ]


def text(bench):
    return bench.twin.node.slave.entry(0x2005, 0).read()


@pytest.mark.spec("T-032")
def test_what_is_longer_than_four_bytes_is_read_in_segments(bench):
    name = b"Probe of the engine".hex().upper()  # 19 bytes: 7 + 7 + 5
    assert bench.send(READ_NAME) == ["585#4108100013000000"]
    assert send(bench, "6000000000000000", "70" + "00" * 7, "60" + "00" * 7) == [
        "00" + name[:14],
        "10" + name[14:28],
        "05" + name[28:] + "0000",
    ]


@pytest.mark.spec("T-033")
def test_nothing_is_left_to_read_after_the_last_segment(bench):
    send(bench, "4008100000000000", "60" + "00" * 7, "70" + "00" * 7, "60" + "00" * 7)
    assert send(bench, "70" + "00" * 7) == ["8000000001000405"]


@pytest.mark.parametrize(
    ("content", "segments"),
    [
        (b"", ["0F" + "00" * 7]),
        (b"12345", ["0531323334350000"]),
        (b"1234567", ["0131323334353637"]),
        (b"12345678", ["0031323334353637", "1D38000000000000"]),
        (b"12345678901234", ["0031323334353637", "1138393031323334"]),
    ],
)
def test_every_length_ends_in_the_right_segment(bench, content, segments):
    bench.device.content = content
    answers = send(bench, "4004210000000000", "60" + "00" * 7)
    if len(segments) > 1:
        answers += send(bench, "70" + "00" * 7)
    assert answers == [f"41042100{len(content):02X}000000", *segments]


def test_a_value_is_read_as_it_was_when_the_transfer_began(bench):
    bench.device.content = b"before it changed"
    send(bench, "4004210000000000")
    bench.device.content = b"after"
    assert send(bench, "60" + "00" * 7) == ["00" + b"before ".hex().upper()]


@pytest.mark.spec("T-032")
@pytest.mark.parametrize("initiate", ["2105200009000000", "2005200000000000"])
def test_a_value_is_written_in_segments_with_or_without_its_size(bench, initiate):
    assert send(bench, initiate, "0031323334353637") == ["60" + TEXT + "00000000", "20" + "00" * 7]
    assert text(bench) == b"text"  # nothing before the last segment
    assert send(bench, "1B38390000000000") == ["30" + "00" * 7]
    assert text(bench) == b"123456789"


@pytest.mark.parametrize(
    ("multiplexer", "size", "segment"),
    [("012000", 2, "0BCDAB0000000000"), ("052000", 3, "0941424300000000"), ("062000", 0, "0F")],
)
def test_a_short_value_may_be_written_in_segments_too(bench, multiplexer, size, segment):
    answers = send(bench, f"21{multiplexer}{size:02X}000000", segment.ljust(16, "0"))
    assert answers == [f"60{multiplexer}00000000", "20" + "00" * 7]
    index = int.from_bytes(bytes.fromhex(multiplexer)[:2], "little")
    assert bench.twin.node.slave.entry(index, 0).read().hex() == segment[2 : 2 + 2 * size].lower()


@pytest.mark.spec("T-033")
def test_a_toggle_bit_that_does_not_alternate_ends_a_download(bench):
    send(bench, "2105200010000000", "0031323334353637")
    assert send(bench, "0031323334353637") == ["80" + TEXT + "00000305"]
    assert send(bench, "1131323334353637") == ["8000000001000405"]
    assert text(bench) == b"text"


@pytest.mark.spec("T-033")
@pytest.mark.parametrize(("segments", "wrong"), [(0, "70"), (1, "60"), (2, "70")])
def test_a_toggle_bit_that_does_not_alternate_ends_an_upload(bench, segments, wrong):
    bench.send(READ_NAME)
    for n in range(segments):
        send(bench, ("60", "70")[n % 2] + "00" * 7)
    assert send(bench, wrong + "00" * 7) == ["8008100000000305"]
    assert send(bench, "60" + "00" * 7) == ["8000000001000405"]


@pytest.mark.spec("T-033")
@pytest.mark.parametrize("initiate", ["4008100000000000", "2105200010000000"])
def test_an_abort_of_the_client_ends_a_transfer_without_an_answer(bench, initiate):
    send(bench, initiate)
    assert send(bench, "8005200000000008") == []
    for segment in ("60" + "00" * 7, "01" + "00" * 7):
        assert send(bench, segment) == ["8000000001000405"]


@pytest.mark.spec("T-033")
@pytest.mark.parametrize("between", ["4000200000000000", "2F00200000000000", "40FF2F0000000000"])
def test_a_new_initiate_ends_an_open_transfer(bench, between):
    send(bench, "2105200010000000", "0031323334353637", between)
    assert send(bench, "1131323334353637") == ["8000000001000405"]
    assert text(bench) == b"text"


def test_a_new_initiate_begins_its_own_transfer(bench):
    send(bench, "2105200010000000", "0031323334353637")
    assert send(bench, "2105200003000000", "0941424300000000")[1] == "20" + "00" * 7
    assert text(bench) == b"ABC"


@pytest.mark.parametrize(
    ("initiate", "wrong", "aborted"),
    [
        ("2105200010000000", "60", TEXT),  # a segment of the other direction
        ("4008100000000000", "00", "081000"),
        ("2105200010000000", "E0", TEXT),  # no request at all
        ("4008100000000000", "E0", "081000"),
    ],
)
def test_what_does_not_continue_a_transfer_aborts_it_by_its_name(bench, initiate, wrong, aborted):
    send(bench, initiate)
    assert send(bench, wrong + "00" * 7) == [f"80{aborted}01000405"]
    assert send(bench, "60" + "00" * 7) == ["8000000001000405"]


@pytest.mark.parametrize(
    ("initiate", "segments"),
    [
        ("2105200003000000", ["0031323334353637"]),
        ("2105200008000000", ["0031323334353637", "1938393000000000"]),
    ],
)
def test_more_data_than_announced_are_refused(bench, initiate, segments):
    *confirmed, refused = send(bench, initiate, *segments)
    assert {answer[:1] for answer in confirmed} <= set("623")
    assert refused == f"80{TEXT}12000706"
    assert text(bench) == b"text"


def test_fewer_data_than_announced_are_refused(bench):
    assert send(bench, "2105200009000000", "0131323334353637")[1] == f"80{TEXT}13000706"
    assert text(bench) == b"text"


@pytest.mark.parametrize(
    ("segment", "code"),
    [("0931323300000000", "12"), ("0D31000000000000", "13"), ("0131323334353637", "12")],
)
def test_without_size_the_length_is_that_of_the_object(bench, segment, code):
    assert send(bench, "2001200000000000", segment)[1] == f"80012000{code}000706"
    assert bench.sdo["Word"].raw == 0x1234


def test_more_than_the_object_has_room_for_is_refused_when_it_comes(bench):
    answers = send(bench, "200A200000000000", "0031323334353637", "1031323334353637")
    assert answers[1:] == ["20" + "00" * 7, "800A200012000706"]


def test_more_than_the_profile_allows_is_refused_when_it_is_announced(bench_of):
    bench = bench_of(longest_transfer=8)
    assert send(bench, "2106200009000000") == [f"80{DOMAIN}12000706"]
    assert send(bench, "2106200008000000") == [f"60{DOMAIN}00000000"]


def test_more_than_the_profile_allows_is_refused_when_it_comes(bench_of):
    bench = bench_of(longest_transfer=8)
    answers = send(bench, "2006200000000000", "0031323334353637", "1931323300000000")
    assert answers[1:] == ["20" + "00" * 7, f"80{DOMAIN}12000706"]


def test_a_refused_value_is_told_with_the_last_segment(bench):
    assert send(bench, "2103200002000000", "0B65000000000000")[1] == "8003200031000906"
    assert bench.sdo["Limited"].raw == 0


def test_a_transfer_that_nobody_continues_is_aborted(bench):
    send(bench, "2105200010000000", "0031323334353637")
    bench.run(9.0)
    assert send(bench, "1031323334353637") == ["30" + "00" * 7]  # the time counts from here
    assert bench.run(9.999) == []
    assert bench.run(0.001) == [abort(TEXT, Abort.TIME_OUT)]
    assert bench.run(100.0) == []
    assert send(bench, "0131323334353637") == ["8000000001000405"]


def test_the_profile_says_how_long_a_transfer_may_be_left(bench_of):
    bench = bench_of(transfer_time_out=0.5)
    bench.send(READ_NAME)
    assert bench.run(1.0) == [abort("081000", Abort.TIME_OUT)]


@pytest.mark.parametrize(
    "requests",
    [
        ["2105200003000000", "0941424300000000"],
        ["4008100000000000", "60" + "00" * 7, "70" + "00" * 7, "60" + "00" * 7],
        ["4008100000000000", "8000000000000000"],
        ["4008100000000000", "E000000000000000"],
    ],
)
def test_a_transfer_that_is_over_does_not_time_out(bench, requests):
    send(bench, *requests)
    assert bench.run(100.0) == []


def test_nothing_can_be_written_after_the_last_segment(bench):
    send(bench, "2105200003000000", "0941424300000000")
    assert send(bench, "1941424300000000") == ["8000000001000405"]
    assert text(bench) == b"ABC"


def test_a_transfer_goes_on_when_the_node_goes_operational(bench):
    send(bench, "2105200003000000")
    bench.send("000#0105")
    assert send(bench, "0941424300000000") == ["20" + "00" * 7]


@pytest.mark.parametrize("command", ["000#0205", "000#8205", "000#8105"])
def test_a_transfer_does_not_outlive_a_state_without_sdo(bench, command):
    send(bench, "2105200003000000")
    bench.send(command)
    bench.send("000#8005")
    assert send(bench, "0941424300000000") == ["8000000001000405"]
    assert bench.run(100.0) == []
    assert text(bench) == b"text"


def test_frames_that_are_no_requests_do_not_disturb_a_transfer(bench):
    send(bench, "2105200003000000")
    for frame in ("605#09414243", "606#8000000000000000", "605#R", "00000605#8000000000000000"):
        bench.send(frame)
    assert send(bench, "0941424300000000") == ["20" + "00" * 7]


@settings(max_examples=30)
@given(st.binary(max_size=100))
def test_a_real_client_reads_back_whatever_it_has_written(content):
    bench = Bench.of({"probe": Probe()})
    bench.sdo.download(0x2006, 0, content)
    assert bench.twin.node.slave.entry(0x2006, 0).read() == content
    bench.device.content = content
    assert bench.sdo.upload(0x2104, 0) == content
