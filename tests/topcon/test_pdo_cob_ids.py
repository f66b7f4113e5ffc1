import pytest

from .bus import START, SYNC, refused

REQUEST, ZEROS = "185#R", "0000000000000000"
RECEIVED = {("Receive", n): 0x40000105 + 0x100 * n for n in range(1, 5)}
SENT = {("Transmit", 1): 0x185}
SENT |= {("Transmit", n): 0x80000085 + 0x100 * n for n in range(2, 5)}
OFF = 1 << 31
NO_RTR = 1 << 30
OTHER_SERVICES = [0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF]
OTHER_SERVICES += [0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x7FF]
MORE_THAN_11_BITS = [1 << bit | 0x205 for bit in range(11, 30)]


def record(bench, kind, number=1):
    return bench.sdo[f"{kind} PDO {number} Communication Parameter"]


def cob_id(bench, kind, number=1):
    return record(bench, kind, number)[1]


def voltage(bench):
    return bench.sdo["Voltage reference"].raw


@pytest.fixture
def operational(topcon):
    topcon.send(START)
    return topcon


@pytest.mark.spec("T-125", "T-146")
@pytest.mark.parametrize(("kind", "number"), [*RECEIVED, ("Transmit", 1)])
def test_an_identifier_changes_only_by_way_of_bit_31(operational, kind, number):
    entry = cob_id(operational, kind, number)
    before = (RECEIVED | SENT)[kind, number]
    with refused(0x06090030):
        entry.raw = before + 1
    assert entry.raw == before
    entry.raw = before | OFF
    assert entry.raw == before | OFF
    entry.raw = before + 1
    assert entry.raw == before + 1


@pytest.mark.spec("T-125")
@pytest.mark.parametrize("type_", [254, 1])
def test_an_rpdo_is_heard_by_its_new_identifier_only(operational, type_):
    record(operational, "Receive")["transmission type"].raw = type_
    cob_id(operational, "Receive").raw = 0xC0000206
    cob_id(operational, "Receive").raw = 0x40000206
    operational.send("205#E803")
    operational.send(SYNC)
    assert voltage(operational) == 0
    operational.send("206#E803")
    operational.send(SYNC)
    assert voltage(operational) == 1000


@pytest.mark.spec("T-125")
def test_an_rpdo_with_bit_31_is_not_received(operational):
    cob_id(operational, "Receive").raw = 0xC0000205
    assert operational.send("205#E8") == []
    assert operational.send("205#E803") == []
    assert voltage(operational) == 0
    cob_id(operational, "Receive").raw = 0x40000205
    operational.send("205#E803")
    assert voltage(operational) == 1000


@pytest.mark.spec("T-146")
def test_a_tpdo_answers_to_its_new_identifier_only(operational):
    cob_id(operational, "Transmit").raw = 0x80000185
    assert operational.send(REQUEST) == []
    cob_id(operational, "Transmit").raw = 0x186
    assert operational.send(REQUEST) == []
    assert operational.send("186#R") == [f"186#{ZEROS}"]


@pytest.mark.spec("T-146")
def test_a_cyclic_tpdo_is_sent_with_its_new_identifier(operational):
    record(operational, "Transmit")["Transmission type"].raw = 1
    cob_id(operational, "Transmit").raw = 0x80000185
    assert operational.send(SYNC) == []
    cob_id(operational, "Transmit").raw = 0x6DF
    assert operational.send(SYNC) == [f"6DF#{ZEROS}"]


@pytest.mark.spec("A-26")
@pytest.mark.parametrize(("written", "kept"), [(0x80000205, 0xC0000205), (0x00000205, 0x40000205)])
def test_bit_30_of_an_rpdo_reads_1_whatever_is_written(topcon, written, kept):
    cob_id(topcon, "Receive").raw = written
    assert cob_id(topcon, "Receive").raw == kept


@pytest.mark.spec("T-146", "A-27")
@pytest.mark.parametrize(("kind", "number"), SENT)
@pytest.mark.parametrize("off", [0, OFF])
def test_bit_30_of_a_tpdo_is_always_0(topcon, kind, number, off):
    with refused(0x06090030):
        cob_id(topcon, kind, number).raw = SENT[kind, number] | NO_RTR | off
    assert cob_id(topcon, kind, number).raw == SENT[kind, number]


@pytest.mark.spec("A-29", "A-39")
@pytest.mark.parametrize(("kind", "valid"), [("Receive", NO_RTR), ("Transmit", 0)])
def test_identifiers_of_other_services_and_bits_beyond_it_are_refused(topcon, kind, valid):
    entry = cob_id(topcon, kind)
    entry.raw = before = (RECEIVED | SENT)[kind, 1] | OFF
    for value in OTHER_SERVICES + MORE_THAN_11_BITS:
        with refused(0x06090030):
            entry.raw = valid | value
        assert entry.raw == before, hex(value)


@pytest.mark.spec("A-29")
@pytest.mark.parametrize(("kind", "bit_30"), [("Receive", NO_RTR), ("Transmit", 0)])
def test_a_pdo_that_is_off_may_have_any_identifier(topcon, kind, bit_30):
    for value in OTHER_SERVICES:
        cob_id(topcon, kind).raw = OFF | bit_30 | value
        assert cob_id(topcon, kind).raw == OFF | bit_30 | value
