import canopen
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame, pattern
from canopen_twins.bus.wire import Wire, through
from canopen_twins.errors import UserError

DATA = st.binary(max_size=8)
STANDARD = st.builds(Frame, st.integers(0, 0x7FF), DATA, st.just(False), st.just(False))
EXTENDED = st.builds(Frame, st.integers(0, 0x1FFFFFFF), DATA, st.just(False), st.just(True))
REMOTE = st.builds(Frame, st.integers(0, 0x7FF), st.just(b""), st.just(True), st.just(False))


@pytest.mark.parametrize(
    ("text", "frame"),
    [
        ("605#4000100000000000", Frame(0x605, bytes.fromhex("4000100000000000"))),
        ("605#40.00.10.00", Frame(0x605, bytes.fromhex("40001000"))),
        (" 080# ", Frame(0x080)),
        ("185#R", Frame(0x185, remote=True)),
        ("185#R8", Frame(0x185, remote=True)),
        ("7ff#aB", Frame(0x7FF, b"\xab")),
        ("00000605#00", Frame(0x605, b"\0", extended=True)),
        ("1FFFFFFF#R", Frame(0x1FFFFFFF, remote=True, extended=True)),
    ],
)
def test_frames_are_read_as_cansend_reads_them(text, frame):
    assert Frame.parse(text) == frame


@pytest.mark.parametrize(
    "text",
    [
        "",
        "605",
        "605 40",
        "5#00",
        "0605#00",
        "xyz#00",
        "605#0",
        "605#0g",
        "605#112233445566778899",
        "605#R9",
        "605##100",
    ],
)
def test_what_is_no_frame_is_an_error_of_the_user(text):
    with pytest.raises(UserError):
        Frame.parse(text)


@pytest.mark.parametrize(("text", "last"), [("800#00", "7FF"), ("20000000#00", "1FFFFFFF")])
def test_an_identifier_beyond_the_last_is_an_error_that_names_the_last(text, last):
    with pytest.raises(UserError, match=last):
        Frame.parse(text)


@settings(max_examples=50)
@given(st.one_of(STANDARD, EXTENDED, REMOTE))
def test_a_frame_is_written_as_it_is_read(frame):
    assert Frame.parse(str(frame)) == frame


def test_what_is_sent_waits_in_the_outbox_in_its_order_with_its_sender():
    wire = Wire(Clock())
    wire.put(Frame(0x705, b"\0"))
    wire.send_message(0x80, b"")
    wire.send_message(0x185, [], remote=True)
    assert [(sender, str(frame)) for sender, frame in wire.outbox] == [
        (wire, "705#00"),
        (wire, "080#"),
        (wire, "185#R"),
    ]


def test_wires_that_share_an_outbox_keep_their_common_order():
    clock = Clock()
    left = Wire(clock)
    right = Wire(clock, left.outbox)
    for wire in (left, right, left):
        wire.put(Frame(1))
    assert [sender for sender, _ in left.outbox] == [left, right, left]


def test_canopen_sends_through_a_wire_unchanged():
    wire = Wire(Clock())
    wire.nmt.state = "OPERATIONAL"
    wire.send_message(0x12345, b"")
    assert isinstance(wire, canopen.Network)
    assert [str(frame) for _, frame in wire.outbox] == ["000#0100", "00012345#"]


def test_a_periodic_frame_is_a_timer_of_the_clock():
    clock = Clock()
    wire = Wire(clock)
    task = wire.send_periodic(0x80, b"\1", 0.1)
    clock.advance(0.25)
    task.update(b"\2")
    clock.advance(0.1)
    task.stop()
    clock.advance(1.0)
    assert [str(frame) for _, frame in wire.outbox] == ["080#01", "080#01", "080#02"]


@pytest.mark.parametrize(
    ("text", "like", "unlike"),
    [
        ("185#xx05", ["185#0005", "185#FF05"], ["185#0006", "185#000500", "186#0005"]),
        ("7xx#*", ["705#05", "7FF#", "700#R"], ["605#05", "00000705#05"]),
        ("185#40.10*", ["185#4010", "185#401020"], ["185#40", "185#R"]),
        ("185#R", ["185#R"], ["185#"]),
    ],
)
def test_x_is_any_digit_and_a_star_any_rest(text, like, unlike):
    assert [frame for frame in like + unlike if pattern(text).fullmatch(frame)] == like


@pytest.mark.parametrize("text", ["", "185", "185#x", "185#*00", "8xx#", "1*#00"])
def test_what_is_no_frame_is_no_pattern_either(text):
    with pytest.raises(UserError):
        pattern(text)


def test_a_frame_goes_through_every_filter_as_the_one_before_sends_it_onward():
    def twice(frame, onward):
        onward(frame)
        onward(frame)

    def longer(frame, onward):
        onward(frame._replace(data=frame.data + b"\1"))

    wire = Wire(Clock())
    wire.outgoing += [twice, longer]
    wire.put(Frame(5))
    wire.outgoing.append(lambda frame, onward: None)
    wire.put(Frame(6))
    assert [str(frame) for _, frame in wire.outbox] == ["005#01", "005#01"]


def test_without_a_filter_a_frame_is_at_the_end_at_once():
    arrived = []
    through([], Frame(5), arrived.append)
    assert arrived == [Frame(5)]
