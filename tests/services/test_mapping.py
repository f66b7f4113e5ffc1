import pytest
from probe import Fixed, configure

from canopen_twins import Bench
from canopen_twins.slave.object import Abort

WORD, DOUBLE, EIGHT, BYTE = 0x20010010, 0x20020020, 0x200A0040, 0x20000008
THIRD = 0x200D0308
RECEIVED, SENT = "1602", "1A02"  # the mappings of RPDO 3 and TPDO 3, which are off


def entry(record, subindex, value):
    index = bytes.fromhex(record)[::-1].hex().upper()
    return f"605#23{index}{subindex:02X}{value.to_bytes(4, 'little').hex().upper()}"


def count(record, number):
    index = bytes.fromhex(record)[::-1].hex().upper()
    return f"605#2F{index}00{number:02X}000000"


def is_refused(bench, request, code):
    multiplexer = request[6:12]
    before = bench.send(f"605#40{multiplexer}00000000")
    refused = f"585#80{multiplexer}{code.to_bytes(4, 'little').hex().upper()}"
    return bench.send(request) == [refused] and bench.send(f"605#40{multiplexer}00000000") == before


@pytest.fixture(params=[RECEIVED, SENT], ids=["RPDO", "TPDO"])
def record(request):
    return request.param


def test_a_remapped_tpdo_carries_the_new_objects_in_their_order(operational):
    configure(
        operational,
        entry(SENT, 1, BYTE),
        entry(SENT, 2, DOUBLE),
        entry(SENT, 3, THIRD),
        count(SENT, 3),
        "605#2302180185030000",
    )
    operational.sdo["Byte"].raw = 0xAB
    operational.sdo["Double word"].raw = 0x01020304
    assert operational.send("385#R") == ["385#AB0403020103"]


def test_a_remapped_rpdo_brings_the_new_objects_in_their_order(operational):
    configure(
        operational,
        entry(RECEIVED, 1, WORD),
        entry(RECEIVED, 2, THIRD),
        count(RECEIVED, 2),
        "605#2302140105040000",
    )
    operational.send("405#CDABEF")
    assert operational.sdo["Word"].raw == 0xABCD
    assert operational.sdo["With a gap"]["Third"].raw == 0xEF


def test_only_as_many_objects_as_the_count_says_are_carried(operational):
    configure(
        operational,
        entry(SENT, 1, BYTE),
        entry(SENT, 2, WORD),
        count(SENT, 1),
        "605#2302180185030000",
    )
    assert operational.send("385#R") == ["385#00"]


def test_a_pdo_carries_up_to_64_bits(bench, record):
    configure(bench, entry(record, 1, EIGHT), entry(record, 2, BYTE), count(record, 1))
    assert is_refused(bench, count(record, 2), Abort.PDO_TOO_LONG)


def test_more_objects_than_the_record_has_are_refused(bench, record):
    configure(bench, *(entry(record, sub, BYTE) for sub in (1, 2, 3)), count(record, 3))
    for number in (4, 64, 253):
        assert is_refused(bench, count(record, number), Abort.PDO_TOO_LONG)


@pytest.mark.parametrize("number", [254, 255])
def test_a_multiplexed_pdo_is_refused(bench, record, number):
    assert is_refused(bench, count(record, number), Abort.INVALID_VALUE)


def test_an_unused_entry_takes_no_room(operational):
    configure(
        operational,
        entry(SENT, 1, BYTE),
        entry(SENT, 2, 0),
        entry(SENT, 3, WORD),
        count(SENT, 3),
        "605#2302180185030000",
    )
    assert operational.send("385#R") == ["385#003412"]


@pytest.mark.parametrize(("index", "cob_id"), [("1600", "0014"), ("1A00", "0018")])
def test_a_mapping_changes_while_its_pdo_is_off_only(bench, index, cob_id):
    assert is_refused(bench, count(index, 0), Abort.ACCESS)
    assert is_refused(bench, entry(index, 1, BYTE), Abort.ACCESS)
    configure(bench, f"605#23{cob_id}0185010080", count(index, 0), entry(index, 1, BYTE))


def test_a_mapping_of_nothing_changes_while_its_pdo_is_off_only():
    bench = Bench.of({"probe": Fixed()})
    assert is_refused(bench, entry(RECEIVED, 1, BYTE), Abort.ACCESS)


def test_an_object_changes_while_the_count_is_0_only(bench, record):
    configure(bench, entry(record, 1, BYTE), count(record, 1))
    assert is_refused(bench, entry(record, 1, WORD), Abort.ACCESS)
    assert is_refused(bench, entry(record, 2, WORD), Abort.ACCESS)
    configure(bench, count(record, 0), entry(record, 1, WORD))


@pytest.mark.parametrize(
    ("value", "code"),
    [
        (0x2FFF0008, Abort.NO_OBJECT),
        (0x20000108, Abort.NO_SUBINDEX),
        (0x200B0018, Abort.NOT_MAPPABLE),  # an entry no PDO carries
        (0x20000009, Abort.NOT_MAPPABLE),  # longer than it is
        (0x20010011, Abort.NOT_MAPPABLE),
        (0x20000000, Abort.NOT_MAPPABLE),  # no length at all
        (0x20050020, Abort.NOT_MAPPABLE),  # not by its file
        (0x20060008, Abort.NOT_MAPPABLE),
    ],
)
def test_what_cannot_be_mapped_is_refused(bench, record, value, code):
    assert is_refused(bench, entry(record, 1, value), code)


def test_an_entry_may_be_mapped_to_nothing(bench, record):
    configure(bench, entry(record, 1, BYTE), entry(record, 1, 0))


def test_what_is_write_only_cannot_be_sent_but_received(bench):
    assert is_refused(bench, entry(SENT, 1, 0x20070010), Abort.NOT_MAPPABLE)
    configure(bench, entry(RECEIVED, 1, 0x20070010))


def test_what_is_read_only_can_be_sent_but_not_received(bench):
    assert is_refused(bench, entry(RECEIVED, 1, 0x21050020), Abort.NOT_MAPPABLE)
    configure(bench, entry(SENT, 1, 0x21050020))


def test_what_is_for_one_direction_is_not_mapped_in_the_other(bench):
    assert is_refused(bench, entry(SENT, 1, 0x21020008), Abort.NOT_MAPPABLE)  # rww
    assert is_refused(bench, entry(RECEIVED, 1, 0x21060008), Abort.NOT_MAPPABLE)  # rwr
    configure(bench, entry(SENT, 1, 0x21060008), entry(RECEIVED, 1, 0x21020008))


def test_a_dummy_fills_a_gap_of_an_rpdo(operational):
    configure(
        operational,
        entry(RECEIVED, 1, 0x00060010),
        entry(RECEIVED, 2, BYTE),
        count(RECEIVED, 2),
        "605#2302140105040000",
    )
    operational.send("405#CDABEF")
    assert operational.sdo["Byte"].raw == 0xEF
    operational.send("405#CD01")
    assert operational.sdo["Byte"].raw == 0xEF


@pytest.mark.parametrize(
    "value", [0x00070020, 0x00010001, 0x00080020, 0x00060110], ids="{:08X}".format
)
def test_a_dummy_is_one_of_the_eds(bench, value):
    assert is_refused(bench, entry(RECEIVED, 1, value), Abort.NO_OBJECT)


def test_a_dummy_is_not_longer_than_its_type(bench):
    assert is_refused(bench, entry(RECEIVED, 1, 0x00060011), Abort.NOT_MAPPABLE)
    configure(bench, entry(RECEIVED, 1, 0x0006000F))


@pytest.mark.parametrize(("record", "pdo"), [(RECEIVED, "1402"), (SENT, "1802")])
def test_a_pdo_comes_into_being_with_a_mapping_only(bench, record, pdo):
    cob_id = {"1402": 0x40000405, "1802": 0x385}[pdo]
    assert is_refused(bench, entry(pdo, 1, cob_id), Abort.INVALID_VALUE)
    configure(bench, entry(record, 1, BYTE), entry(record, 2, 0), count(record, 2))
    configure(bench, entry(pdo, 1, cob_id))


def test_a_dummy_cannot_be_sent(bench):
    assert is_refused(bench, entry(SENT, 1, 0x00060010), Abort.NO_OBJECT)


def test_canopen_s_own_configuration_of_a_pdo_is_accepted(bench):
    remote = bench.twin.remote
    remote.tpdo.read()
    remote.rpdo.read()
    tpdo, rpdo = remote.tpdo[3], remote.rpdo[3]
    for pdo, name in ((tpdo, "Word"), (rpdo, "Limited")):
        pdo.clear()
        pdo.add_variable(name)
        pdo.add_variable("Byte")
        pdo.enabled = True
    tpdo.trans_type, rpdo.trans_type = 1, 255
    remote.tpdo.save()
    remote.rpdo.save()
    bench.send("000#0105")
    rpdo["Limited"].raw, rpdo["Byte"].raw = -5, 6
    rpdo.transmit()
    assert bench.send("080#") == ["285#00000000", "385#341206"]
    assert bench.sdo["Limited"].raw == -5
