import pytest

from canopen_twins import Bench

from .bus import START, SYNC, aborted, read, refused

READ_ONLY = 0x06010002


def cob_ids(node_id):
    """Tab. 17, 22, 25, 28-31, 37-40."""
    rows = {(0x1005, 0): 0x80, (0x1014, 0): 0x80 + node_id}
    rows |= {(0x1200, 1): 0x600 + node_id, (0x1200, 2): 0x580 + node_id}
    rows |= {(0x1400 + n, 1): 0x40000200 + 0x100 * n + node_id for n in range(4)}
    tpdos = (0x180, 0x80000280, 0x80000380, 0x80000480)
    return rows | {(0x1800 + n, 1): base + node_id for n, base in enumerate(tpdos)}


@pytest.fixture
def sync_sent(topcon):
    """A TopCon that answers every SYNC."""
    topcon.sdo["Transmit PDO 1 Communication Parameter"]["Transmission type"].raw = 1
    topcon.send(START)
    return topcon


@pytest.mark.spec("T-100")
def test_there_is_no_device_profile(topcon):
    assert topcon.send("605#4000100000000000") == ["585#4300100000000000"]
    assert aborted(topcon.send("605#2300100001000000")) == (0x1000, 0, READ_ONLY)


@pytest.mark.spec("T-101", "A-11")
def test_the_error_register_begins_with_0_and_is_read_only(topcon):
    assert topcon.send("605#4001100000000000") == ["585#4F01100000000000"]
    assert aborted(topcon.send("605#2F01100000000000")) == (0x1001, 0, READ_ONLY)


@pytest.mark.spec("T-106", "A-17", "A-18", "A-19")
def test_the_names_are_plain_text_without_quotes(topcon):
    names = ("Manufacturer Device Name", "Manufacturer Hardware Version")
    assert [topcon.sdo[name].raw for name in names] == ["TopCon Quadro", "V4.x"]
    assert topcon.sdo["Manufacturer Software Version"].raw == "V4.11.45"
    for index in (0x1008, 0x1009, 0x100A):
        with refused(READ_ONLY):
            topcon.sdo[index].raw = "mine"


@pytest.mark.spec("T-110", "T-113", "T-115", "T-120", "T-140", "A-25")
@pytest.mark.parametrize("node_id", [1, 5, 29, 127])
def test_the_default_cob_ids_are_those_of_the_tables(node_id):
    bench = Bench("topcon", node_id=node_id)
    expected = cob_ids(node_id)
    assert {at: bench.sdo.upload(*at) for at in expected} == {
        at: value.to_bytes(4, "little") for at, value in expected.items()
    }


@pytest.mark.spec("T-113", "A-22")
def test_the_identifier_of_emergencies_is_fixed(topcon):
    assert aborted(topcon.send("605#2314100085000080")) == (0x1014, 0, READ_ONLY)


@pytest.mark.spec("T-115", "T-036")
def test_the_identifiers_of_the_sdo_server_are_fixed(topcon):
    assert topcon.sdo["Server SDO Parameter"][0].raw == 2
    for subindex in (0, 1, 2):
        assert aborted(topcon.send(f"605#2300120{subindex}00000000")) == (
            0x1200,
            subindex,
            READ_ONLY,
        )


@pytest.mark.spec("T-114", "A-24")
def test_the_identity_object(topcon):
    identity = topcon.sdo["Identity Object"]
    assert [identity[subindex].raw for subindex in range(5)] == [4, 0x1C4, 0, 0x00000009, 1]
    for subindex in range(5):
        with refused(READ_ONLY):
            identity[subindex].raw = 0


@pytest.mark.spec("T-111")
def test_the_identifier_of_sync_is_80h_and_can_be_written(topcon):
    assert read(topcon, 0x1005) == ["585#4305100080000000"]
    assert topcon.send("605#2305100085000000") == ["585#6005100000000000"]
    assert read(topcon, 0x1005) == ["585#4305100085000000"]


@pytest.mark.spec("T-111", "A-16", "A-29")
@pytest.mark.parametrize(
    "value",
    [1 << bit | 0x80 for bit in range(11, 32)]
    + [0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF],
    ids=hex,
)
def test_no_sync_has_an_identifier_of_another_service_or_a_bit_beyond_it(topcon, value):
    with refused(0x06090030):
        topcon.sdo["COB-ID SYNC message"].raw = value
    assert topcon.sdo["COB-ID SYNC message"].raw == 0x80


@pytest.mark.spec("T-111", "A-29")
@pytest.mark.parametrize("value", [0x80, 0xFF, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700])
def test_sync_may_have_every_identifier_that_is_free(topcon, value):
    topcon.sdo["COB-ID SYNC message"].raw = value
    assert topcon.sdo["COB-ID SYNC message"].raw == value


@pytest.mark.spec("T-112")
def test_a_new_sync_identifier_acts_at_once(sync_sent):
    sync_sent.sdo["COB-ID SYNC message"].raw = 0x90
    assert sync_sent.send(SYNC) == []
    assert sync_sent.send("090#") == ["185#0000000000000000"]


@pytest.mark.spec("T-112")
def test_rpdos_follow_the_new_sync_identifier_too(topcon):
    topcon.sdo["Receive PDO 1 Communication Parameter"]["transmission type"].raw = 1
    topcon.sdo["COB-ID SYNC message"].raw = 0x90
    topcon.send(START)
    topcon.send("205#E803")
    topcon.send(SYNC)
    assert topcon.sdo["Voltage reference"].raw == 0
    topcon.send("090#")
    assert topcon.sdo["Voltage reference"].raw == 1000


@pytest.mark.spec("A-10", "A-51")
def test_the_manufacturer_objects_lie_in_the_range_that_tab_10_calls_unused(topcon):
    names = ["Nominal voltage", "Voltage reference", "Run command", "State of output"]
    assert [topcon.sdo[name].od.index for name in names] == [0x2000, 0x2010, 0x2014, 0x2023]
