from binascii import crc_hqx

import pytest
from canopen.sdo.exceptions import SdoAbortedError
from hypothesis import given, settings
from hypothesis import strategies as st
from probe import Probe

from canopen_twins import Bench
from canopen_twins.slave.object import Abort

BYTES, TEXT, DOMAIN, WORD = "042100", "052000", "062000", "012000"
START, END_OF_UPLOAD = "A3" + "00" * 7, "A1" + "00" * 7


def send(bench, *frames):
    """The answers to several requests, without their common identifier."""
    answers = [answer for frame in frames for answer in bench.send(f"605#{frame}")]
    return [answer.removeprefix("585#") for answer in answers]


def aborted(multiplexer, code):
    return [f"80{multiplexer}{code.to_bytes(4, 'little').hex().upper()}"]


def segments(content, first=0, blksize=127):
    """The frames of one block: `first` counts the segments that are there already."""
    parts = [content[at : at + 7] for at in range(0, len(content), 7)] or [b""]
    block = parts[first : first + blksize]
    return [
        f"{number | 0x80 * (first + number == len(parts)):02X}{part.hex().upper():0<14}"
        for number, part in enumerate(block, 1)
    ]


def end(content, command=0xC1, crc=None):
    unused = -len(content) % 7 if content else 7
    checksum = crc_hqx(content, 0) if crc is None else crc
    return f"{command | unused << 2:02X}{checksum.to_bytes(2, 'little').hex().upper()}" + "00" * 5


def upload(bench, content, blksize=127, command="A4"):
    """Initiate and start; the frames of the first block."""
    bench.device.content = content
    size = len(content).to_bytes(4, "little").hex().upper()
    assert send(bench, f"{command}{BYTES}{blksize:02X}000000") == [f"C6{BYTES}{size}"]
    return send(bench, START)


def confirm(ackseq, blksize=127):
    return f"A2{ackseq:02X}{blksize:02X}" + "00" * 5


def initiate(bench, multiplexer=DOMAIN, command="C4", size=0):
    answers = send(bench, f"{command}{multiplexer}{size.to_bytes(4, 'little').hex()}")
    assert answers == [f"A4{multiplexer}7F000000"]


def domain(bench):
    return bench.twin.node.slave.entry(0x2006, 0).read()


@pytest.fixture
def bench(bench_of):
    return bench_of(block=True)


@pytest.mark.parametrize("length", [0, 1, 6, 7, 8, 14, 100, 889])
def test_a_value_is_read_in_one_block(bench, length):
    content = bytes(n % 256 for n in range(length))
    block = upload(bench, content)
    assert block == segments(content)
    assert send(bench, confirm(len(block))) == [end(content)]
    assert send(bench, END_OF_UPLOAD) == []
    assert send(bench, END_OF_UPLOAD) == aborted("000000", Abort.COMMAND)
    assert bench.run(100.0) == []


def test_a_long_value_is_read_in_several_blocks_as_long_as_the_client_wants(bench):
    content = bytes(range(200))
    assert upload(bench, content, blksize=4) == segments(content, 0, 4)
    assert send(bench, confirm(4, 20)) == segments(content, 4, 20)
    assert send(bench, confirm(20, 1)) == segments(content, 24, 1)
    assert send(bench, confirm(1, 127)) == segments(content, 25)
    assert send(bench, confirm(4, 127)) == [end(content)]


@pytest.mark.parametrize("ackseq", [0, 1, 5, 9])
def test_what_follows_the_last_segment_received_is_sent_again(bench, ackseq):
    content = bytes(range(100))
    upload(bench, content, blksize=10)
    assert send(bench, confirm(ackseq, 10)) == segments(content, ackseq, 10)


def test_the_last_block_is_sent_again_as_well(bench):
    content = bytes(range(20))
    assert len(upload(bench, content)) == 3
    assert send(bench, confirm(2)) == segments(content, 2)
    assert send(bench, confirm(0)) == segments(content, 2)
    assert send(bench, confirm(1)) == [end(content)]


def test_without_crc_the_end_has_none(bench):
    upload(bench, b"12345", command="A0")
    assert send(bench, confirm(1)) == [end(b"12345", crc=0)]


def test_the_crc_is_that_of_the_xmodem_protocol(bench):
    upload(bench, b"123456789")
    assert send(bench, confirm(2)) == ["D5C3310000000000"]  # 31C3h, its check value


@pytest.mark.parametrize("blksize", [0, 128, 255])
def test_a_block_has_1_to_127_segments(bench, blksize):
    bench.device.content = b"123456789"
    refused = aborted(BYTES, Abort.BLOCK_SIZE)
    assert send(bench, f"A4{BYTES}{blksize:02X}000000") == refused
    upload(bench, b"123456789", blksize=1)
    assert send(bench, confirm(1, blksize)) == refused
    assert send(bench, confirm(1, 1)) == aborted("000000", Abort.COMMAND)


def test_more_segments_than_were_sent_cannot_be_confirmed(bench):
    upload(bench, bytes(100), blksize=5)
    assert send(bench, confirm(6)) == aborted(BYTES, Abort.SEQUENCE_NUMBER)


@pytest.mark.parametrize(
    ("before", "wrong"),
    [
        ([], confirm(0)),
        ([], END_OF_UPLOAD),
        ([START], START),
        ([START], END_OF_UPLOAD),
        ([START, confirm(2)], START),
        ([START, confirm(2)], confirm(2)),
    ],
)
def test_what_comes_out_of_turn_ends_an_upload(bench, before, wrong):
    bench.device.content = b"123456789"
    send(bench, f"A4{BYTES}7F000000", *before)
    assert send(bench, wrong) == aborted(BYTES, Abort.COMMAND)
    assert send(bench, START) == aborted("000000", Abort.COMMAND)


@pytest.mark.parametrize(
    ("length", "threshold", "answer"),
    [
        (4, 4, f"43{BYTES}00000000"),
        (3, 200, f"47{BYTES}00000000"),
        (20, 20, f"41{BYTES}14000000"),
        (21, 20, f"C6{BYTES}15000000"),
        (4, 0, f"C6{BYTES}04000000"),
    ],
)
def test_a_short_value_is_read_the_other_way_if_the_client_says_up_to_where(
    bench, length, threshold, answer
):
    bench.device.content = bytes(length)
    assert send(bench, f"A4{BYTES}7F{threshold:02X}0000") == [answer]


def test_a_switched_transfer_goes_on_in_segments(bench):
    bench.device.content = b"1234567"
    send(bench, f"A4{BYTES}7F070000")
    assert send(bench, "60" + "00" * 7) == ["0131323334353637"]


@pytest.mark.parametrize(
    ("multiplexer", "code"),
    [("FF2F00", Abort.NO_OBJECT), ("002001", Abort.NO_SUBINDEX), ("072000", Abort.WRITE_ONLY)],
)
def test_what_cannot_be_read_is_refused(bench, multiplexer, code):
    assert send(bench, f"A4{multiplexer}7F000000") == aborted(multiplexer, code)


@pytest.mark.parametrize("length", [0, 1, 6, 7, 8, 14, 100, 889])
@pytest.mark.parametrize("command", ["C4", "C6"])
def test_a_value_is_written_in_one_block(bench, length, command):
    content = bytes(n % 256 for n in range(length))
    initiate(bench, command=command, size=length)
    block = segments(content)
    assert send(bench, *block) == [f"A2{len(block):02X}7F0000000000"]
    assert domain(bench) == b""  # nothing before the end
    assert send(bench, end(content)) == ["A1" + "00" * 7]
    assert domain(bench) == content
    assert send(bench, end(content)) == aborted("000000", Abort.COMMAND)
    assert bench.run(100.0) == []


def test_a_long_value_is_written_in_several_blocks(bench):
    content = bytes(n % 251 for n in range(2000))
    initiate(bench)
    confirmed = [send(bench, *segments(content, first)) for first in (0, 127, 254)]
    assert confirmed == [["A27F7F0000000000"], ["A27F7F0000000000"], ["A2207F0000000000"]]
    send(bench, end(content))
    assert domain(bench) == content


@pytest.mark.parametrize("lost", [1, 5, 126, 127])
def test_what_follows_a_gap_in_a_block_is_sent_again(bench, lost):
    content = bytes(n % 251 for n in range(1000))
    initiate(bench)
    block = segments(content)
    answers = send(bench, *(block[: lost - 1] + block[lost:]))
    if lost == 127:  # of this one the server cannot know
        answers = send(bench, block[-1])
        lost = 128
    assert answers == [f"A2{lost - 1:02X}7F0000000000"]
    send(bench, *segments(content, lost - 1), end(content))
    if len(content) > 7 * (lost - 1 + 127):
        send(bench, *segments(content, lost - 1 + 127), end(content))
    assert domain(bench) == content


def test_a_last_segment_after_a_gap_is_not_the_end(bench):
    content = bytes(range(30))
    initiate(bench)
    block = segments(content)
    assert send(bench, block[0], block[1], block[4]) == ["A2027F0000000000"]
    assert send(bench, *segments(content, 2), end(content)) == [
        "A2037F0000000000",
        "A1" + "00" * 7,
    ]
    assert domain(bench) == content


def test_a_segment_that_comes_twice_is_taken_once(bench):
    content = bytes(range(20))
    initiate(bench)
    first, second, third = segments(content)
    assert send(bench, first, first, second, first, third, end(content))[-1] == "A1" + "00" * 7
    assert domain(bench) == content


def test_a_wrong_crc_is_told_and_nothing_is_written(bench):
    initiate(bench)
    send(bench, *segments(b"123456789"))
    assert send(bench, end(b"123456789", crc=0x1234)) == aborted(DOMAIN, Abort.CRC)
    assert domain(bench) == b""


def test_a_client_without_crc_is_not_checked(bench):
    initiate(bench, command="C0")
    send(bench, *segments(b"123456789"))
    assert send(bench, end(b"123456789", crc=0x1234)) == ["A1" + "00" * 7]
    assert domain(bench) == b"123456789"


def test_a_segment_has_a_number(bench):
    initiate(bench)
    assert send(bench, "00" + "11" * 7) == aborted(DOMAIN, Abort.SEQUENCE_NUMBER)


@pytest.mark.parametrize("segment", ["20", "2F", "40", "60", "7F"])
def test_while_a_block_is_under_way_every_frame_is_a_segment(bench, segment):
    initiate(bench)
    answers = send(bench, f"{segment}00200001020304")
    assert answers in ([], ["A2007F0000000000"])
    assert bench.twin.node.slave.number(0x2000) == 0
    assert send(bench, *segments(b"12", 0), end(b"12"))[-1] == "A1" + "00" * 7


def test_an_abort_is_no_segment(bench):
    initiate(bench)
    first, *_ = segments(bytes(100))
    assert send(bench, first, f"80{DOMAIN}00000008") == []
    assert send(bench, f"40{WORD}00000000") == [f"4B{WORD}34120000"]
    assert bench.run(100.0) == []


@pytest.mark.parametrize("wrong", ["81" + "00" * 7, "A3" + "00" * 7, "01" + "00" * 7, "E0" * 8])
def test_after_the_last_block_only_the_end_belongs_to_a_download(bench, wrong):
    initiate(bench)
    send(bench, *segments(b"123456789"))
    answers = send(bench, wrong)
    assert answers == ([] if wrong.startswith("8") else aborted(DOMAIN, Abort.COMMAND))
    assert send(bench, end(b"123456789")) == aborted("000000", Abort.COMMAND)
    assert domain(bench) == b""


@pytest.mark.parametrize("steps", [[], [START], [START, confirm(2)]])
def test_a_new_initiate_ends_an_upload(bench, steps):
    bench.device.content = b"123456789"
    send(bench, f"A4{BYTES}7F000000", *steps)
    assert send(bench, "2F00200007000000") == ["6000200000000000"]
    assert send(bench, confirm(2)) == aborted("000000", Abort.COMMAND)


def test_after_the_last_block_a_new_initiate_ends_the_download(bench):
    initiate(bench)
    send(bench, *segments(b"123456789"))
    assert send(bench, f"40{WORD}00000000") == [f"4B{WORD}34120000"]
    assert send(bench, end(b"123456789")) == aborted("000000", Abort.COMMAND)


@pytest.mark.parametrize(
    ("size", "code"), [(8, Abort.TOO_LONG), (10, Abort.TOO_SHORT), (16, Abort.TOO_SHORT)]
)
def test_not_as_many_bytes_as_announced_are_refused(bench, size, code):
    initiate(bench, command="C6", size=size)
    answers = send(bench, *segments(b"123456789"), end(b"123456789"))
    assert answers[1:] == aborted(DOMAIN, code)
    assert domain(bench) == b""


def test_far_more_than_announced_are_refused_with_the_block(bench):
    initiate(bench, command="C6", size=20)
    content = bytes(1000)
    assert send(bench, *segments(content)) == aborted(DOMAIN, Abort.TOO_LONG)


@pytest.mark.parametrize(("size", "fits"), [(889, True), (888, False), (882, False)])
def test_a_whole_block_that_is_not_the_last_has_no_unused_bytes(bench, size, fits):
    initiate(bench, command="C6", size=size)
    answers = send(bench, *segments(bytes(1000)))
    assert answers == (["A27F7F0000000000"] if fits else aborted(DOMAIN, Abort.TOO_LONG))


def test_more_than_the_profile_allows_is_refused(bench_of):
    bench = bench_of(block=True, longest_transfer=8)
    assert send(bench, f"C6{DOMAIN}09000000") == aborted(DOMAIN, Abort.TOO_LONG)
    initiate(bench)
    assert send(bench, *segments(bytes(16))) == aborted(DOMAIN, Abort.TOO_LONG)


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("C4FF2F0000000000", Abort.NO_OBJECT),
        ("C400200100000000", Abort.NO_SUBINDEX),
        ("C409200000000000", Abort.READ_ONLY),
        ("C601200003000000", Abort.TOO_LONG),
        ("C601200001000000", Abort.TOO_SHORT),
    ],
)
def test_what_cannot_be_written_is_refused_when_it_begins(bench, request_, code):
    assert send(bench, request_) == aborted(request_[2:8], code)


def test_a_refused_value_is_told_at_the_end(bench):
    initiate(bench, "032000")
    assert send(bench, *segments(b"\x65\0"), end(b"\x65\0"))[1:] == aborted("032000", 0x06090031)


def test_a_number_may_be_written_in_a_block(bench):
    initiate(bench, WORD, "C6", 2)
    send(bench, *segments(b"\xcd\xab"), end(b"\xcd\xab"))
    assert bench.sdo["Word"].raw == 0xABCD


def test_a_block_that_nobody_continues_is_aborted(bench):
    initiate(bench)
    first, second, *_ = segments(bytes(100))
    send(bench, first)
    bench.run(9.0)
    send(bench, second)
    assert bench.run(9.999) == []
    assert bench.run(0.001) == ["585#" + aborted(DOMAIN, Abort.TIME_OUT)[0]]
    upload(bench, bytes(100))
    assert bench.run(100.0) == ["585#" + aborted(BYTES, Abort.TIME_OUT)[0]]


@pytest.mark.parametrize("command", ["000#0205", "000#8205"])
def test_a_block_transfer_does_not_outlive_a_state_without_sdo(bench, command):
    initiate(bench)
    bench.send(command)
    bench.send("000#8005")
    assert send(bench, "01" + "00" * 7) == aborted("000000", Abort.COMMAND)
    assert bench.run(100.0) == []


@settings(max_examples=25)
@given(st.binary(min_size=1, max_size=2000))  # canopen sends no block for nothing
def test_a_real_client_reads_back_whatever_it_has_written(content):
    bench = Bench.of({"probe": Probe(block=True)})
    with bench.sdo["Domain"].open("wb", size=len(content), block_transfer=True) as file:
        file.write(content)
    bench.device.content = bench.twin.node.slave.entry(0x2006, 0).read()
    with bench.sdo["Bytes"].open("rb", block_transfer=True) as file:
        assert file.read() == content


def test_a_real_client_recovers_from_lost_segments(bench):
    content = bytes(n % 251 for n in range(3000))
    node, count = bench.twin.node, 0
    receive = node.receive

    def lossy(frame):
        nonlocal count
        count += frame.can_id == 0x605
        if count not in (50, 200):
            receive(frame)

    node.receive = lossy
    with bench.sdo["Domain"].open("wb", size=len(content), block_transfer=True) as file:
        file.write(content)
    assert domain(bench) == content


def test_a_real_client_is_refused(bench):
    with (
        pytest.raises(SdoAbortedError) as refusal,
        bench.sdo["Constant"].open("wb", size=2, block_transfer=True),
    ):
        pass
    assert refusal.value.code == Abort.READ_ONLY


def test_expedited_and_segmented_transfer_are_there_all_the_same(bench):
    bench.sdo["Text"].raw = "longer than one segment"
    assert bench.sdo["Text"].raw == "longer than one segment"
    assert bench.sdo["Word"].raw == 0x1234
