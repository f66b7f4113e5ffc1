import pytest
from charger_bus import START, aborted, ask, put, refused, release, value

from canopen_twins import Bench

HARDWARE, MEMORY = "0E3#005001010B000000", "0E3#006301010C000000"
CLEARED_HARDWARE = "0E3#000000010B000000"


def clear(bench, number, subindex=1):
    """Write 0x2003 by hand: the answer and what else comes."""
    return bench.send(f"663#2F0320{subindex:02X}{number:02X}000000")


def confirmed(subindex=1):
    return f"5E3#600320{subindex:02X}00000000"


@pytest.mark.spec("C-030", "C-031", "C-032", "C-033", "C-034")
@pytest.mark.parametrize(
    ("fault", "key", "frame"),
    [
        ("error", "hardware", "0E3#005001010B000000"),
        ("error", "temp_cascade", "0E3#0042090106000000"),
        ("error", "supply_current", "0E3#0021030103000000"),
        ("warning", "temp_inside", "0E3#0042090504000000"),
        ("warning", "limiter_voltage", "0E3#0033050508000000"),
        ("warning", "pollution_charging", "0E3#009001050B000000"),
    ],
)
def test_code_register_type_and_number(bench, fault, key, frame):
    bench.inject(fault, key=key)
    assert bench.sent[-1] == frame
    assert value(bench, 1, 0x6000) == {"error": 0x02, "warning": 0x04}[fault]


@pytest.mark.spec("C-035")
def test_a_message_is_told_once(quiet):
    quiet.inject("error", key="hardware")
    quiet.inject("error", key="hardware")
    quiet.run(60.0)
    assert quiet.sent.count(HARDWARE) == 1


@pytest.mark.spec("C-036", "C-042", "A-36")
def test_each_clear_is_confirmed_with_what_remains(bench):
    bench.inject("error", key="hardware")
    bench.inject("warning", key="temp_inside")
    bench.clear()
    assert clear(bench, 0x0B) == [confirmed(), "0E3#000009010B000000"]
    assert clear(bench, 0x04, subindex=2) == [confirmed(2), "0E3#0000000504000000"]


@pytest.mark.spec("C-036", "C-043")
def test_clearing_in_the_other_order_leaves_the_other_bits(bench):
    bench.inject("error", key="hardware")
    bench.inject("warning", key="temp_inside")
    bench.clear()
    assert clear(bench, 0x04, subindex=2) == [confirmed(2), "0E3#0000010504000000"]
    assert clear(bench, 0x0B) == [confirmed(), CLEARED_HARDWARE]


@pytest.mark.spec("A-36")
def test_the_other_reading_confirms_without_saying_what():
    bench = Bench("charger", ack_payload="zero")
    bench.inject("error", key="hardware")
    bench.inject("warning", key="temp_inside")
    bench.clear()
    assert clear(bench, 0x0B)[1] == "0E3#0000090000000000"


@pytest.mark.spec("C-037", "C-045", "A-35")
def test_nothing_is_cleared_while_the_cause_lasts(quiet):
    quiet.inject("error", key="hardware")
    assert clear(quiet, 0x0B) == [confirmed()]
    assert value(quiet, 1, 0x6000) == 0x02
    quiet.clear("error")
    assert quiet.run(10.0) == []
    assert clear(quiet, 0x0B) == [confirmed(), CLEARED_HARDWARE]


@pytest.mark.spec("C-037", "C-045", "A-35")
def test_clearing_what_is_not_there_is_confirmed_and_does_nothing(bench):
    bench.inject("error", key="hardware")
    for number in (0x01, 0x0C, 0x50):
        assert clear(bench, number) == [confirmed()]
    assert clear(bench, 0x0B, subindex=2) == [confirmed(2)]  # a warning of this number
    assert bench.sdo[0x1001].raw == 0x01


@pytest.mark.spec("C-044")
@pytest.mark.parametrize(("subindex", "highest"), [(1, 0x50), (2, 0x60)])
def test_numbers_that_no_message_has_are_refused(bench, subindex, highest):
    for number, code in ((0, 0x06090032), (highest + 1, 0x06090031), (0xFF, 0x06090031)):
        assert aborted(clear(bench, number, subindex)) == (0x2003, subindex, code)
    assert clear(bench, highest, subindex) == [confirmed(subindex)]


@pytest.mark.spec("C-046", "A-22")
def test_what_clears_cannot_be_read(bench):
    assert ask(bench, 0x2003) == ["5E3#4F03200005000000"]
    for subindex in (1, 2):
        assert aborted(ask(bench, 0x2003, subindex)) == (0x2003, subindex, 0x06010001)
    for subindex in (3, 4, 5):
        assert aborted(ask(bench, 0x2003, subindex)) == (0x2003, subindex, 0x06090011)


@pytest.mark.spec("C-038")
def test_the_identifier_is_fixed(bench):
    assert bench.sdo[0x1014].raw == 0xE3
    with refused(0x06010002):
        bench.sdo[0x1014].raw = 0xE4


@pytest.mark.spec("C-039", "C-032", "A-29")
def test_0x1001_is_the_register_of_the_emcy(bench):
    assert bench.sdo[0x1001].raw == 0x00
    seen = []
    for key in ("supply_low", "temp_inside", "strong_sparks"):
        bench.inject("warning", key=key)
        seen.append(int(bench.sent[-1][8:10], 16))
        assert bench.sdo[0x1001].raw == seen[-1]
    assert seen == [0x05, 0x0D, 0x0F]


@pytest.mark.spec("C-040", "C-041", "A-30")
def test_0x1003_has_the_newest_message_with_type_and_number(bench):
    assert [value(bench, sub, 0x1003) for sub in (0, 1)] == [0, 0]
    bench.inject("error", key="hardware")
    assert [value(bench, sub, 0x1003) for sub in (0, 1)] == [1, 0x0B015000]
    bench.inject("warning", key="temp_inside")
    assert [value(bench, sub, 0x1003) for sub in (0, 1)] == [1, 0x04054200]
    bench.clear()
    clear(bench, 0x04, subindex=2)
    assert value(bench, 1, 0x1003) == 0x04054200
    assert aborted(ask(bench, 0x1003, 2)) == (0x1003, 2, 0x06090011)


@pytest.mark.spec("C-040", "A-30")
def test_writing_0_erases_it_and_nothing_else_does(bench):
    bench.inject("error", key="hardware")
    for number in (1, 2, 0xFE, 0xFF):
        with refused(0x06090030):
            bench.sdo[0x1003][0].raw = number
    assert value(bench, 1, 0x1003) == 0x0B015000
    with refused(0x06010002):
        bench.sdo[0x1003][1].raw = 0
    bench.sdo[0x1003][0].raw = 0
    assert [value(bench, sub, 0x1003) for sub in (0, 1)] == [0, 0]
    assert bench.sdo[0x1001].raw == 0x01


@pytest.mark.spec("C-143", "A-48")
def test_an_error_blocks_the_release_until_it_is_cleared_and_a_warning_does_not(on):
    on.inject("warning", key="supply_high")
    assert value(on, 1, 0x6000) == 0x2D
    on.inject("error", key="hardware")
    assert value(on, 1, 0x6000) == 0x06
    on.sdo[0x6200][1].raw = 0x0F
    assert value(on, 1, 0x6000) == 0x06
    on.clear()
    clear(on, 0x0B)
    assert value(on, 1, 0x6000) == 0x04  # nothing comes back by itself
    on.sdo[0x6200][1].raw = 0x0F
    assert value(on, 1, 0x6000) == 0x2D


@pytest.mark.spec("C-142", "A-47")
def test_a_lost_hardware_release_is_no_message_and_ramps_up_again(on):
    on.send(START)
    on.inject("hardware_release_lost")
    assert value(on, 1, 0x6000) == 0x20
    on.run(2.0)
    on.clear("hardware_release_lost")
    assert value(on, 1, 0x6000) == 0x29
    on.run(0.25)
    assert value(on, 1, 0x6401) == 10_000
    assert not [frame for frame in on.sent if frame.startswith("0E3#")]


@pytest.mark.spec("C-007", "A-26")
@pytest.mark.parametrize("command", ["000#8163", "000#8263"])
def test_after_a_reset_of_the_node_an_error_is_told_anew(quiet, command):
    quiet.inject("error", key="hardware")
    told = quiet.send(command) == ["763#00", HARDWARE]
    assert told is (command == "000#8163")
    assert quiet.sdo[0x1001].raw == 0x01


@pytest.mark.spec("C-039")
def test_a_memory_that_fails_is_an_error_of_its_own(bench):
    bench.inject("memory_failure")
    assert bench.sent[-1] == MEMORY
    release(bench)
    assert value(bench, 1, 0x6000) == 0x02
    put(bench, {1: 0x0C}, index=0x2003)
    assert bench.sdo[0x1001].raw == 0x01
