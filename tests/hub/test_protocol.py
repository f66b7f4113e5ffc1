import can
import pytest
from can.interfaces.socketcand.socketcand import (
    convert_ascii_message_to_can_message,
    convert_can_message_to_ascii_message,
)
from hypothesis import given
from hypothesis import strategies as st

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.hub.protocol import (
    LONGEST,
    Refused,
    Stream,
    delivered,
    read_delivered,
    read_sent,
    sent,
)

NO, YES = st.just(False), st.just(True)
BASIC_ID, EXTENDED_ID = st.integers(0, 0x7FF), st.integers(0, 0x1FFFFFFF)
DATA, NO_DATA = st.binary(max_size=8), st.just(b"")
STANDARD = st.builds(Frame, BASIC_ID, DATA, NO, NO)
EXTENDED = st.builds(Frame, EXTENDED_ID, DATA, NO, YES)
REMOTE = st.builds(Frame, BASIC_ID, NO_DATA, YES, NO) | st.builds(
    Frame, EXTENDED_ID, NO_DATA, YES, YES
)
NOT_ASKED_FOR = STANDARD.filter(lambda frame: frame.data or frame.can_id < 0x180)
FRAMES = NOT_ASKED_FOR | EXTENDED | REMOTE


def only(data):
    (element,) = Stream().feed(data)
    return element


@given(FRAMES)
def test_a_frame_arrives_as_it_was_sent(frame):
    arrived = read_sent(only(sent(frame)))
    assert arrived == frame
    assert read_delivered(only(delivered(arrived, 1.5))) == frame


@given(NOT_ASKED_FOR | EXTENDED)
def test_python_can_sends_what_we_read(frame):
    message = can.Message(
        arbitration_id=frame.can_id, data=frame.data, is_extended_id=frame.extended
    )
    text = convert_can_message_to_ascii_message(message)
    assert read_sent(only(text.encode())) == frame


@given(NOT_ASKED_FOR | EXTENDED)
def test_python_can_reads_what_we_send(frame):
    message = convert_ascii_message_to_can_message(delivered(frame, 12.25).decode())
    assert message
    assert (message.arbitration_id, message.data, message.is_extended_id) == (
        frame.can_id,
        frame.data,
        frame.extended,
    )
    assert message.timestamp == 12.25


REMOTE_OF_PYTHON_CAN = [(0x185, 0), (0x2FF, 0), (0x705, 0), (0x123, 8), (0x605, 1)]


@pytest.mark.parametrize(("can_id", "length"), REMOTE_OF_PYTHON_CAN)
def test_a_remote_frame_of_python_can_is_known_by_its_missing_data(can_id, length):
    message = can.Message(
        arbitration_id=can_id, is_remote_frame=True, dlc=length, is_extended_id=False
    )
    text = convert_can_message_to_ascii_message(message)
    assert read_sent(only(text.encode())) == Frame(can_id, remote=True)


@pytest.mark.parametrize("can_id", [0x000, 0x080, 0x085, 0x180, 0x200, 0x205, 0x605, 0x700, 0x7E5])
def test_a_frame_without_data_is_one_where_it_has_a_meaning(can_id):
    assert read_sent(f"send {can_id:03X} 0") == Frame(can_id)


def test_an_rtr_without_a_name_for_it_is_left_alone_by_python_can():
    assert (
        convert_ascii_message_to_can_message(delivered(Frame(5, remote=True), 1).decode()) is None
    )


@given(st.lists(FRAMES, min_size=1, max_size=5), st.data())
def test_elements_come_out_however_the_bytes_are_cut(frames, data):
    whole = b"".join(map(sent, frames))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(whole)), max_size=8)))
    stream = Stream()
    elements = []
    for start, end in zip([0, *cuts], [*cuts, len(whole)], strict=True):
        elements += stream.feed(whole[start:end])
    assert [read_sent(text) for text in elements] == frames


@pytest.mark.parametrize("text", [b" " * 129, b"\n" * 4096, b"<send 123 0>" + b" " * 129])
def test_blanks_without_end_are_refused(text):
    with pytest.raises(Refused, match="more than 128 bytes and no end"):
        list(Stream().feed(text))


@pytest.mark.parametrize("space", ["<send 123 0>", "\n<  send\t123  0 >\r\n"])
def test_space_does_not_matter(space):
    assert read_sent(only(space.encode())) == Frame(0x123)


@given(st.binary(max_size=300))
def test_whatever_comes_is_read_or_refused(data):
    stream = Stream()
    try:
        for text in [*stream.feed(data), *stream.feed(data[::-1])]:
            read_sent(text)
    except Refused:
        pass


@pytest.mark.parametrize(
    "data",
    [b"GET / HTTP/1.1\r\n", b"<" + b" " * LONGEST + b"x", b"< \xff >", b"< a < b >", b">", b"hi"],
)
def test_what_is_no_element_is_refused(data):
    with pytest.raises(Refused):
        list(Stream().feed(data))


@pytest.mark.parametrize(
    "text",
    [
        "send",
        "send 800 0",
        "send 20000000 0",
        "send 123456789 0",
        "send 123 9 1 2 3 4 5 6 7 8 9",
        "send 123 F 1 2 3",
        "send 123 2 11",
        "send 123 1 111",
        "send -12 0",
        "send 1_2 0",
        "sendrtr 800 0",
        "sendrtr 123",
    ],
)
def test_what_is_no_frame_is_refused(text):
    with pytest.raises(Refused):
        read_sent(text)
