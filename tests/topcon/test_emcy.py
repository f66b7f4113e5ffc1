import pytest

from canopen_twins import Bench

from .bus import ENTER_PREOP, RESET_COMMUNICATION, RESET_NODE, START, STOP, run, state_of_output

GATE_DRIVER_A, NO_ERROR = "085#0023032300000000", "085#0000000000000000"
CONFIRMED = "585#6014200000000000"
RESET_ERRORS = "605#2B14200002000000"


def register(bench):
    return bench.sdo["Error Register"].raw


@pytest.mark.spec("T-050", "T-052", "T-102", "A-64")
def test_the_printed_example_is_sent_as_printed(topcon):
    topcon.inject("error", number=0x23)
    assert topcon.sent[-1] == GATE_DRIVER_A
    assert register(topcon) == 0x03


@pytest.mark.spec("T-050")
@pytest.mark.parametrize("node_id", [1, 29, 127])
def test_the_identifier_is_80h_plus_the_node_id(node_id):
    bench = Bench("topcon", node_id=node_id)
    bench.inject("error", number=0x23)
    assert bench.sent[-1] == f"{0x80 + node_id:03X}#0023032300000000"


@pytest.mark.spec("T-051", "A-60", "A-72")
def test_an_error_is_told_once_however_often_it_comes(topcon):
    topcon.inject("lasting_error", number=0x23)
    for _ in range(3):
        topcon.inject("error", number=0x23)
        topcon.run(1.0)
    topcon.clear("lasting_error")
    topcon.inject("lasting_error", number=0x23)
    assert topcon.sent == ["705#00", GATE_DRIVER_A]


@pytest.mark.spec("T-053", "T-054", "T-176")
def test_a_reset_ends_it_and_a_new_occurrence_is_told_again(topcon):
    topcon.inject("error", number=0x23)
    assert topcon.send(RESET_ERRORS) == [CONFIRMED, NO_ERROR]
    assert register(topcon) == 0
    assert topcon.send(RESET_ERRORS) == [CONFIRMED]
    topcon.inject("error", number=0x23)
    assert topcon.sent[-1] == GATE_DRIVER_A


@pytest.mark.spec("T-055", "A-41")
def test_a_set_value_beyond_its_limit_by_rpdo_is_a_protocol_error(topcon):
    topcon.send(START)
    assert topcon.send("205#A10F") == ["085#0082110000000000"]
    assert topcon.send("205#A10F") == []
    assert topcon.send(RESET_ERRORS) == [CONFIRMED, NO_ERROR]
    assert topcon.send("205#A10F") == ["085#0082110000000000"]


@pytest.mark.spec("T-056", "T-101", "A-12")
def test_with_several_errors_the_register_has_the_bits_of_them_all(topcon):
    for number, sent, shown in (
        (0x23, "085#0023032300000000", 0x03),
        (0x30, "085#0033073000000000", 0x07),
        (0x51, "085#00420F5100000000", 0x0F),
        (0x67, "085#00811F6700000000", 0x1F),
        (0xF2, "085#00909FF200000000", 0x9F),
    ):
        topcon.inject("error", number=number)
        assert topcon.sent[-1] == sent
        assert register(topcon) == shown


@pytest.mark.spec("T-101", "A-73")
@pytest.mark.parametrize(
    ("number", "bits"), [(0x23, 0x03), (0x30, 0x05), (0x51, 0x09), (0x67, 0x11), (0x100, 0x81)]
)
def test_the_error_register_tells_what_kind_of_error_it_is(topcon, number, bits):
    assert register(topcon) == 0
    topcon.inject("error", number=number)
    assert register(topcon) == bits
    topcon.sdo["Run command"].raw = 2
    assert register(topcon) == 0


@pytest.mark.spec("A-12", "A-61", "A-49")
def test_no_message_says_that_some_of_several_errors_are_gone(topcon):
    topcon.inject("error", number=0x23)
    topcon.inject("lasting_error", number=0x30)
    assert topcon.send(RESET_ERRORS) == [CONFIRMED]
    assert register(topcon) == 0x05
    topcon.clear()
    assert register(topcon) == 0x05  # latched
    assert topcon.send(RESET_ERRORS) == [CONFIRMED, NO_ERROR]


@pytest.mark.spec("A-49")
def test_a_reset_without_an_error_leaves_a_running_unit_alone(topcon):
    run(topcon, voltage=2000)
    topcon.inject("warning")
    assert state_of_output(topcon) & 0x4001 == 0x4001
    assert topcon.send(RESET_ERRORS) == [CONFIRMED]
    assert state_of_output(topcon) & 0x4001 == 0x0001


@pytest.mark.spec("T-016", "T-058", "A-59")
@pytest.mark.parametrize(
    ("command", "boot_up"),
    [(ENTER_PREOP, []), (START, []), (RESET_COMMUNICATION, ["705#00"]), (RESET_NODE, ["705#00"])],
)
def test_an_error_while_stopped_is_told_when_the_node_may_speak_again(topcon, command, boot_up):
    topcon.send(STOP)
    topcon.inject("error", number=0x23)
    topcon.run(1.0)
    assert topcon.sent == ["705#00"]
    assert topcon.send(command) == [*boot_up, GATE_DRIVER_A]
    assert topcon.sdo["Pre-defined Error Field"][1].raw == 0x00232300
    assert topcon.send(STOP) == []
    assert topcon.send(START) == []


@pytest.mark.spec("T-058")
@pytest.mark.parametrize("command", [ENTER_PREOP, START])
def test_an_error_is_told_in_pre_operational_and_operational(topcon, command):
    topcon.send(command)
    topcon.inject("error", number=0x23)
    assert topcon.sent[-1] == GATE_DRIVER_A


@pytest.mark.spec("T-059")
def test_the_last_three_bytes_of_a_message_are_0(topcon):
    for number in (0x00, 0xFF, 0x100, 0x1FF):
        topcon.inject("error", number=number)
    assert [frame[-6:] for frame in topcon.sent[1:]] == 4 * ["000000"]
    assert topcon.sent[-1] == "085#008191FF01000000"


@pytest.mark.spec("A-49")
def test_a_reset_while_the_cause_is_there_changes_nothing(topcon):
    topcon.inject("lasting_error", number=0x23)
    assert topcon.send(RESET_ERRORS) == [CONFIRMED]
    assert (register(topcon), state_of_output(topcon)) == (0x03, 0x8000)


PROTOCOL_ERROR = "085#0082110000000000"


@pytest.mark.spec("T-051", "T-055", "A-41")
def test_an_error_that_the_same_sync_raises_and_resets_is_told_kept_and_over(topcon):
    for frame in ("605#2F00140201000000", "605#2F03140201000000", START, "205#FFFF", "505#0200"):
        topcon.send(frame)
    assert topcon.send("080#") == [PROTOCOL_ERROR, NO_ERROR]
    assert topcon.sdo["Pre-defined Error Field"][0].raw == 1
    assert topcon.sdo["Pre-defined Error Field"][1].raw == 0x8200
    assert register(topcon) == 0


@pytest.mark.spec("T-056", "A-12", "A-92")
def test_errors_held_back_in_stopped_carry_the_register_of_the_moment_they_are_told(topcon):
    topcon.send(STOP)
    topcon.inject("error", number=0x23)
    topcon.run(1.0)
    topcon.inject("lasting_error", number=0x50)
    assert topcon.send(ENTER_PREOP) == ["085#00230B2300000000", "085#00420B5000000000"]
    assert register(topcon) == 0x0B


@pytest.mark.spec("T-051", "T-191")
def test_a_trip_in_the_very_tick_of_its_reset_is_told_too(topcon):
    topcon.set(load="inductor 1 10")
    run(topcon, voltage=4000)
    topcon.run(0.5)
    topcon.sdo["Overcurrent level"].raw = 100
    clock = topcon.clock
    clock.at(
        clock.now + 0.005, lambda: topcon.send(RESET_ERRORS)
    )  # before the node looks at its tick
    told = topcon.run(0.01)
    assert told == ["085#0023032100000000", CONFIRMED, NO_ERROR]
