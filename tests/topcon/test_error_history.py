import csv

import pytest

from canopen_twins.files.shipped import od_file

from .bus import RESET_COMMUNICATION, RESET_NODE, state_of_output

GATE_DRIVER_A = "085#0023032300000000"
RESET_ERRORS = "605#2B14200002000000"


def register(bench):
    return bench.sdo["Error Register"].raw


def history(bench):
    field = bench.sdo["Pre-defined Error Field"]
    return [field[subindex].raw for subindex in range(1, field[0].raw + 1)]


@pytest.mark.spec("T-103", "T-104")
def test_the_history_has_code_and_detail_of_the_last_16_errors_newest_first(topcon):
    numbers = [0x23, 0x30, *range(0x100, 0x110)]
    with od_file("topcon_emcy.csv") as path, path.open(encoding="ascii") as file:
        codes = {int(row["detail"], 16): int(row["code"], 16) for row in csv.DictReader(file)}
    for count, number in enumerate(numbers, 1):
        topcon.inject("error", number=number)
        assert topcon.sdo["Pre-defined Error Field"][0].raw == min(count, 16)
    assert history(topcon) == [number << 16 | codes[number] for number in numbers[:1:-1]]


@pytest.mark.spec("T-103", "A-68")
def test_the_history_entries_and_their_count_have_the_types_of_tab_16(topcon):
    topcon.inject("error", number=0x1FF)
    assert topcon.send("605#4003100000000000") == ["585#4F03100001000000"]
    assert topcon.send("605#4003100100000000") == ["585#430310010081FF01"]


@pytest.mark.spec("T-105")
def test_writing_0_and_only_that_empties_the_history(topcon):
    topcon.inject("error", number=0x23)
    for value in range(1, 256):
        assert topcon.send(f"605#2F031000{value:02X}000000") == ["585#8003100030000906"]
    assert history(topcon) == [0x00232300]
    assert topcon.send("605#2F03100000000000") == ["585#6003100000000000"]
    assert history(topcon) == []
    assert topcon.send("605#4003100100000000") == ["585#4303100100000000"]
    assert register(topcon) == 0x03  # the error is still there, only its record is gone


@pytest.mark.spec("A-15")
def test_neither_an_error_reset_nor_its_message_touches_the_history(topcon):
    topcon.inject("error", number=0x23)
    topcon.send(RESET_ERRORS)
    assert history(topcon) == [0x00232300]


@pytest.mark.spec("A-15", "T-011")
def test_the_history_outlives_a_reset_of_the_communication_and_tells_nothing_twice(topcon):
    topcon.inject("error", number=0x23)
    assert topcon.send(RESET_COMMUNICATION) == ["705#00"]
    assert history(topcon) == [0x00232300]
    assert register(topcon) == 0x03


@pytest.mark.spec("A-15", "A-85")
def test_after_a_reset_of_the_node_the_history_begins_with_what_is_still_wrong(topcon):
    topcon.inject("error", number=0x30)
    topcon.send(RESET_ERRORS)
    topcon.inject("error", number=0x23)
    assert topcon.send(RESET_NODE) == ["705#00", GATE_DRIVER_A]
    assert history(topcon) == [0x00232300]
    assert state_of_output(topcon) == 0x8000


@pytest.mark.spec("A-15", "A-85")
def test_a_power_cycle_forgets_every_error_whose_cause_is_gone(topcon):
    topcon.inject("error", number=0x23)
    topcon.power_off()
    topcon.power_on()
    assert topcon.sent[2:] == ["705#00"]
    assert (history(topcon), register(topcon), state_of_output(topcon)) == ([], 0, 0)
    topcon.inject("lasting_error", number=0x23)
    topcon.power_off()
    topcon.power_on()
    assert topcon.sent[-2:] == ["705#00", GATE_DRIVER_A]
