import pytest

from .bus import aborted, read

READ_NAME, NAME_BEGINS = "605#4008100000000000", ["585#410810000D000000"]  # 13 bytes
WRITE_VOLTAGE, VOLTAGE_BEGINS = "605#2110200002000000", ["585#6010200000000000"]
FIRST, SECOND = ["585#2000000000000000"], ["585#3000000000000000"]
NEXT_SEGMENT = "605#6000000000000000"
NO_TRANSFER = (0, 0, 0x05040001)


def voltage(bench):
    return bench.sdo["Voltage reference"].raw


@pytest.mark.spec("T-032", "T-106")
def test_13_bytes_come_in_segments(topcon):
    assert topcon.send(READ_NAME) == NAME_BEGINS
    assert topcon.send("605#6000000000000000") == ["585#00" + b"TopCon ".hex().upper()]
    assert topcon.send("605#7000000000000000") == ["585#13" + b"Quadro\0".hex().upper()]
    assert topcon.sdo["Manufacturer Device Name"].raw == "TopCon Quadro"


@pytest.mark.spec("T-032")
@pytest.mark.parametrize("begin", [WRITE_VOLTAGE, "605#2010200000000000"])
def test_a_value_may_be_written_in_segments(topcon, begin):
    assert topcon.send(begin) == VOLTAGE_BEGINS
    assert topcon.send("605#0BE8030000000000") == FIRST
    assert voltage(topcon) == 1000


@pytest.mark.spec("T-032")
def test_two_segments_alternate_their_toggle_bit(topcon):
    topcon.send(WRITE_VOLTAGE)
    assert topcon.send("605#0CE8000000000000") == FIRST
    assert topcon.send("605#1D03000000000000") == SECOND
    assert voltage(topcon) == 1000


@pytest.mark.spec("T-032")
def test_nothing_is_written_before_the_last_segment(topcon):
    topcon.send(WRITE_VOLTAGE)
    topcon.send("605#0CE8000000000000")
    assert voltage(topcon) == 0


@pytest.mark.spec("T-033")
@pytest.mark.parametrize(
    ("begin", "segment", "named"),
    [
        (READ_NAME, "605#7000000000000000", "081000"),
        (WRITE_VOLTAGE, "605#1BE8030000000000", "102000"),
    ],
)
def test_a_toggle_bit_that_does_not_alternate_ends_the_transfer(topcon, begin, segment, named):
    topcon.send(begin)
    assert topcon.send(segment) == [f"585#80{named}00000305"]
    assert aborted(topcon.send(segment)) == NO_TRANSFER
    assert voltage(topcon) == 0


@pytest.mark.spec("T-033")
def test_an_abort_of_the_client_ends_the_transfer_without_an_answer(topcon):
    topcon.send(READ_NAME)
    assert topcon.send("605#8008100000000405") == []
    assert aborted(topcon.send(NEXT_SEGMENT)) == NO_TRANSFER


@pytest.mark.spec("T-033")
def test_a_new_initiate_ends_an_open_transfer(topcon):
    topcon.send(READ_NAME)
    assert read(topcon, 0x1000) == ["585#4300100000000000"]
    assert aborted(topcon.send(NEXT_SEGMENT)) == NO_TRANSFER
    assert topcon.send(READ_NAME) == NAME_BEGINS


@pytest.mark.spec("T-033", "A-87")
def test_a_transfer_nobody_goes_on_with_is_given_up(topcon):
    topcon.send(READ_NAME)
    assert topcon.run(9.9) == []
    assert topcon.run(0.2) == ["585#8008100000000405"]
    assert aborted(topcon.send(NEXT_SEGMENT)) == NO_TRANSFER


@pytest.mark.spec("T-033", "A-71")
@pytest.mark.parametrize("segment", [NEXT_SEGMENT, "605#0000000000000000"])
def test_a_segment_of_no_transfer_belongs_to_no_object(topcon, segment):
    assert topcon.send(segment) == ["585#8000000001000405"]


@pytest.mark.spec("T-035")
@pytest.mark.parametrize(
    ("last", "code"), [("0DE8000000000000", 0x06070013), ("09E8030000000000", 0x06070012)]
)
def test_a_length_that_shows_at_the_last_segment_is_refused_too(topcon, last, code):
    topcon.send("605#2010200000000000")  # does not say how many bytes will come
    assert aborted(topcon.send(f"605#{last}")) == (0x2010, 0, code)
    assert voltage(topcon) == 0
