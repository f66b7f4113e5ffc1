import pytest

from .bus import ENTER_PREOP, START, STOP, SYNC, refused

PARAMETER_EXCEEDS_LIMIT = "085#0082110000000000"
RPDOS = {1: 0x205, 2: 0x305, 3: 0x405, 4: 0x505}
SYNCHRONOUS = [0, 1, 2, 239, 240]


def record(bench, number=1):
    return bench.sdo[f"Receive PDO {number} Communication Parameter"]


def cob_id(bench, number=1):
    return record(bench, number)[f"COB-ID RPDO{number}"]


def set_values(bench):
    return [bench.sdo[index].raw for index in (0x2010, 0x2011, 0x2012, 0x2013)]


@pytest.fixture
def operational(topcon):
    topcon.send(START)
    return topcon


@pytest.fixture(params=SYNCHRONOUS)
def synchronous(operational, request):
    """RPDO1 waits for SYNC."""
    record(operational)["transmission type"].raw = request.param
    return operational


@pytest.mark.spec("T-120")
@pytest.mark.parametrize("number", RPDOS)
def test_the_four_rpdos_are_valid_and_asynchronous(topcon, number):
    assert record(topcon, number)[0].raw == 2
    assert cob_id(topcon, number).raw == 0x40000000 + RPDOS[number]
    assert record(topcon, number)["transmission type"].raw == 254
    topcon.send(START)
    assert topcon.send(f"{RPDOS[number]:03X}#R") == []  # no remote requests


@pytest.mark.spec("T-121", "T-131")
@pytest.mark.parametrize(
    ("frame", "after"),
    [
        ("205#E803", [1000, 0, 4000, 0]),
        ("305#E803", [0, 1000, 4000, 0]),
        ("405#E803D007", [0, 0, 1000, 2000]),
    ],
)
def test_data_are_taken_at_reception_and_go_where_the_tables_say(operational, frame, after):
    assert operational.send(frame) == []
    assert set_values(operational) == after


@pytest.mark.spec("T-121", "T-131", "T-175")
def test_rpdo4_carries_the_run_command(operational):
    operational.sdo["Voltage reference"].raw = 2000
    operational.send("505#0100")
    assert operational.sdo["Run command"].raw == 1
    assert operational.sdo["State of output"].raw == 0x0003


@pytest.mark.spec("T-015")
@pytest.mark.parametrize("command", [ENTER_PREOP, STOP])
def test_outside_operational_no_rpdo_is_taken(operational, command):
    operational.send(command)
    operational.send("205#E803")
    operational.send(START)
    operational.send(SYNC)
    assert set_values(operational) == [0, 0, 4000, 0]


@pytest.mark.spec("T-122", "A-30")
def test_the_transmission_types_are_0_to_240_and_254(topcon):
    entry = record(topcon)["transmission type"]
    for value in range(256):
        before = entry.raw
        if value in {*range(241), 254}:
            entry.raw = value
            assert entry.raw == value
        else:
            with refused(0x06090030):
                entry.raw = value
            assert entry.raw == before


@pytest.mark.spec("T-123", "A-67")
def test_data_wait_for_the_next_sync_whatever_the_number(synchronous):
    synchronous.send("205#E803")
    synchronous.run(1.0)
    assert set_values(synchronous)[0] == 0
    synchronous.send(SYNC)
    assert set_values(synchronous)[0] == 1000


@pytest.mark.spec("T-124")
def test_of_two_rpdos_before_one_sync_the_last_counts(synchronous):
    synchronous.send("205#E803")
    synchronous.send("205#D007")
    synchronous.send(SYNC)
    assert set_values(synchronous)[0] == 2000


@pytest.mark.spec("A-36")
def test_data_are_taken_once_and_not_again_at_every_sync(synchronous):
    synchronous.send("205#E803")
    synchronous.send(SYNC)
    synchronous.sdo["Voltage reference"].raw = 1234
    synchronous.send(SYNC)
    assert set_values(synchronous)[0] == 1234


@pytest.mark.spec("T-015", "T-123")
def test_what_waits_for_a_sync_is_forgotten_with_operational(synchronous):
    synchronous.send("205#E803")
    synchronous.send(ENTER_PREOP)
    synchronous.send(START)
    synchronous.send(SYNC)
    assert set_values(synchronous)[0] == 0


@pytest.mark.spec("T-126", "A-37")
@pytest.mark.parametrize("frame", ["205#", "205#E8", "405#E803D0", "405#E803", "505#01"])
def test_an_rpdo_that_is_too_short_is_dropped_and_told(operational, frame):
    assert operational.send(frame) == [PARAMETER_EXCEEDS_LIMIT]
    assert set_values(operational) == [0, 0, 4000, 0]
    assert operational.sdo["Run command"].raw == 0
    assert operational.send(frame) == []  # told once


@pytest.mark.spec("T-126", "A-37")
def test_a_short_rpdo_that_waits_for_sync_is_told_at_once_and_never_taken(synchronous):
    synchronous.send("205#E803")
    assert synchronous.send("205#D0") == [PARAMETER_EXCEEDS_LIMIT]
    synchronous.send(SYNC)
    assert set_values(synchronous)[0] == 1000


@pytest.mark.spec("T-126", "A-37")
def test_of_a_longer_rpdo_the_mapped_bytes_are_used(operational):
    assert operational.send("205#E803FFFFFFFFFFFF") == []
    assert set_values(operational) == [1000, 0, 4000, 0]


@pytest.mark.spec("T-174", "A-41")
@pytest.mark.parametrize(
    "frame", ["205#A10F", "205#FFFF", "305#A10F", "405#A10F0000", "405#A00FA10F"]
)
def test_a_set_value_beyond_its_range_is_dropped_and_told_once(operational, frame):
    assert operational.send(frame) == [PARAMETER_EXCEEDS_LIMIT]
    assert set_values(operational) == [0, 0, 4000, 0]
    assert operational.send(frame) == []


@pytest.mark.spec("T-174", "A-41")
def test_a_value_that_waits_for_sync_is_looked_at_when_it_is_taken(synchronous):
    assert synchronous.send("205#A10F") == []
    assert synchronous.send(SYNC) == [PARAMETER_EXCEEDS_LIMIT]
    assert synchronous.send(SYNC) == []


@pytest.mark.spec("T-174", "A-41")
def test_of_two_values_in_one_rpdo_the_right_one_is_taken(operational):
    operational.send("405#E803A10F")
    assert set_values(operational) == [0, 0, 1000, 0]
    operational.send("405#A10FE803")
    assert set_values(operational) == [0, 0, 1000, 1000]


@pytest.mark.spec("A-41", "A-63")
def test_a_bad_value_does_not_stop_the_output(operational):
    for frame in ("205#D007", "305#A00F", "505#0100", "205#A10F"):
        operational.send(frame)
    operational.run(1.0)
    assert operational.sdo["State of output"].raw == 0x0003
    assert operational.sdo["Actual voltage"].raw == 2000


@pytest.mark.spec("T-177", "A-45", "A-41")
def test_an_unknown_command_is_dropped_and_told(operational):
    assert operational.send("505#0300") == [PARAMETER_EXCEEDS_LIMIT]
    assert operational.sdo["Run command"].raw == 0


@pytest.mark.spec("T-130", "T-131", "A-38")
@pytest.mark.parametrize(
    ("number", "mapped"),
    [(1, [0x20100010]), (2, [0x20110010]), (3, [0x20120010, 0x20130010]), (4, [0x20140010])],
)
def test_the_mapping_is_that_of_the_tables_and_fixed(topcon, number, mapped):
    mapping = topcon.sdo[f"Receive PDO {number} Mapping Parameter"]
    assert [mapping[subindex].raw for subindex in range(len(mapped) + 1)] == [len(mapped), *mapped]
    for subindex in range(len(mapped) + 1):
        with refused(0x06010002):
            mapping[subindex].raw = 0
