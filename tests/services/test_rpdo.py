import pytest
from probe import Fixed, configure

from canopen_twins import Bench

NOW, AT_SYNC = "205#", "305#"  # RPDO 1: Byte, Word; RPDO 2: Double word, type 1
SYNC = "080#"


def values(bench):
    slave = bench.twin.node.slave
    return slave.number(0x2000), slave.number(0x2001), slave.number(0x2002)


def told(bench):
    return [entry for entry in bench.device.told if str(entry).startswith("RPDO")]


@pytest.mark.spec("T-040", "T-121")
def test_an_event_driven_rpdo_is_taken_over_at_once(operational):
    assert operational.send(NOW + "AB3412") == ["185#0000AB"]  # TPDO 1 carries the byte, too
    assert values(operational)[:2] == (0xAB, 0x1234)


@pytest.mark.spec("T-121", "T-122")
@pytest.mark.parametrize("kind", [254, 255])
def test_both_event_driven_types_are_independent_of_sync(operational, kind):
    configure(operational, f"605#2F001402{kind:02X}000000")
    operational.send(NOW + "010203")
    assert values(operational)[0] == 1
    operational.sdo["Byte"].raw = 9
    operational.send(SYNC)
    assert values(operational)[0] == 9


@pytest.mark.spec("T-122", "T-123")
@pytest.mark.parametrize("kind", [0, 1, 2, 240])
def test_a_synchronous_rpdo_is_taken_over_at_the_next_sync_whatever_its_number(operational, kind):
    configure(operational, f"605#2F011402{kind:02X}000000")
    operational.send(AT_SYNC + "04030201")
    assert values(operational)[2] == 0
    operational.send(SYNC)
    assert values(operational)[2] == 0x01020304


@pytest.mark.spec("T-124")
def test_of_two_rpdos_before_a_sync_the_last_wins(operational):
    operational.send(AT_SYNC + "01000000")
    operational.send(AT_SYNC + "02000000")
    operational.send(SYNC)
    assert values(operational)[2] == 2


def test_what_was_taken_over_is_not_taken_over_again(operational):
    operational.send(AT_SYNC + "01000000")
    operational.send(SYNC)
    operational.sdo["Double word"].raw = 5
    operational.send(SYNC)
    assert values(operational)[2] == 5


def test_rpdos_are_taken_over_before_tpdos_are_composed(operational):
    operational.send(AT_SYNC + "01020304")
    assert operational.send(SYNC) == ["285#01020304"]


@pytest.mark.spec("T-126")
def test_an_rpdo_that_is_too_short_is_not_processed_and_told(operational):
    for data in ("", "AB", "AB34"):
        operational.send(NOW + data)
    assert values(operational)[:2] == (0, 0x1234)
    assert told(operational) == [
        f"RPDO 1: {length} bytes, 3 are mapped (06070013h)" for length in (0, 1, 2)
    ]


def test_a_short_synchronous_rpdo_leaves_the_one_before_waiting(operational):
    operational.send(AT_SYNC + "01000000")
    operational.send(AT_SYNC + "020000")
    operational.send(SYNC)
    assert values(operational)[2] == 1


@pytest.mark.spec("T-126")
def test_of_a_longer_rpdo_the_mapped_bytes_are_used(operational):
    operational.send(NOW + "AB3412FFFFFFFFFF")
    assert values(operational)[:2] == (0xAB, 0x1234)
    assert told(operational) == []


@pytest.mark.parametrize("frame", ["205#R", "00000205#AB3412", "206#AB3412"])
def test_what_is_no_rpdo_of_this_node_is_not_taken(operational, frame):
    assert operational.send(frame) == []
    assert values(operational) == (0, 0x1234, 0)


@pytest.mark.spec("T-125")
def test_an_rpdo_that_does_not_exist_is_not_received(operational):
    configure(operational, "605#2300140105020080")
    operational.send(NOW + "AB3412")
    assert values(operational)[0] == 0
    configure(operational, "605#2300140105020000")
    operational.send(NOW + "AB3412")
    assert values(operational)[0] == 0xAB


@pytest.mark.spec("T-125")
def test_a_new_identifier_is_heard_and_the_old_one_is_dead(operational):
    configure(operational, "605#2300140123010080", "605#2300140123020000")
    operational.send(NOW + "010203")
    assert values(operational)[0] == 0
    operational.send("223#040506")
    assert values(operational)[0] == 4


@pytest.mark.spec("T-112")
def test_a_new_sync_identifier_is_heard_and_the_old_one_is_dead(operational):
    configure(operational, "605#2305100090000000")
    operational.send(AT_SYNC + "01000000")
    operational.send(SYNC)
    assert values(operational)[2] == 0
    operational.send("090#")
    assert values(operational)[2] == 1


@pytest.mark.parametrize("command", ["000#8005", "000#0205"])
def test_what_waits_for_a_sync_is_forgotten_with_operational(operational, command):
    operational.send(AT_SYNC + "01000000")
    operational.send(command)
    operational.send("000#0105")
    operational.send(SYNC)
    assert values(operational)[2] == 0


@pytest.mark.parametrize(
    "changes",
    [
        ["605#2301140105030080", "605#2301140105030000"],  # switched off and on again
        ["605#2F011402FE000000", "605#2F01140201000000"],  # event-driven and back
    ],
)
def test_what_waits_for_a_sync_is_forgotten_with_its_kind_of_pdo(operational, changes):
    operational.send(AT_SYNC + "01000000")
    configure(operational, *changes)
    operational.send(SYNC)
    assert values(operational)[2] == 0


def test_what_waits_for_a_sync_stays_when_something_else_changes(operational):
    operational.send(AT_SYNC + "01000000")
    configure(operational, "605#2B17100000000000", "605#2300140105020080")
    operational.send(SYNC)
    assert values(operational)[2] == 1


def test_a_pdo_with_nothing_mapped_takes_any_frame_without_effect():
    operational = Bench.of({"probe": Fixed()})
    operational.send("000#0105")
    for frame in ("405#", "405#0102030405060708"):
        assert operational.send(frame) == []
    assert told(operational) == []


@pytest.fixture
def mapped(operational):
    """RPDO 3 carries Refusing, then Byte."""
    configure(
        operational,
        "605#2302160108000221",
        "605#2302160208000020",
        "605#2F02160002000000",
        "605#2302140105040000",
    )
    return operational


def test_a_value_that_is_refused_is_told_and_the_others_are_taken(mapped):
    mapped.send("405#0107")
    assert told(mapped) == ["RPDO 3: always (08000021h)"]
    assert values(mapped)[0] == 7


def test_a_value_out_of_its_limits_is_refused_like_one_by_sdo(operational):
    configure(
        operational,
        "605#2302160110000320",
        "605#2F02160001000000",
        "605#2302140105040000",
    )
    operational.send("405#6500")
    operational.send("405#9CFF")
    assert told(operational) == ["RPDO 3: 101 is above 100 (06090031h)"]
    assert operational.sdo["Limited"].raw == -100


def test_two_rpdos_may_share_an_identifier(operational):
    configure(operational, "605#2301140105030080", "605#2301140105020000")
    operational.send("205#01020304")
    operational.send(SYNC)
    assert values(operational) == (1, 0x0302, 0x04030201)
