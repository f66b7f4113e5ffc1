import pytest
from probe import configure

RPDO, TPDO, EMCY, SYNC = "001401", "001801", "141000", "051000"
MAPPED, COUNTED = "605#2302160108000020", "605#2F02160001000000"  # of RPDO 3
FREE = {RPDO: 0x205, TPDO: 0x185, EMCY: 0x85}
OFF = 1 << 31
RESTRICTED = [
    *(0x000, 0x001, 0x07F),
    *(0x101, 0x180),
    *(0x581, 0x5FF),
    *(0x601, 0x67F),
    *(0x6E0, 0x6FF),
    *(0x701, 0x77F, 0x7FF),
]
UNRESTRICTED = [0x080, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700]


def write(multiplexer, value):
    return f"605#23{multiplexer}{value.to_bytes(4, 'little').hex().upper()}"


def is_refused(bench, multiplexer, value):
    """Whether the value is refused and the one before stays."""
    before = bench.send(f"605#40{multiplexer}00000000")
    (answer,) = bench.send(write(multiplexer, value))
    if answer == f"585#60{multiplexer}00000000":
        return False
    assert answer == f"585#80{multiplexer}30000906"
    return bench.send(f"605#40{multiplexer}00000000") == before


@pytest.fixture(params=FREE, ids=["RPDO", "TPDO", "EMCY"])
def multiplexer(request):
    return request.param


@pytest.mark.spec("T-125", "T-146")
def test_an_identifier_that_is_in_use_does_not_change(bench, multiplexer):
    assert is_refused(bench, multiplexer, 0x190)


@pytest.mark.spec("T-125", "T-146")
def test_it_changes_by_way_of_bit_31(bench, multiplexer):
    configure(bench, write(multiplexer, FREE[multiplexer] | OFF))
    configure(bench, write(multiplexer, 0x190 | OFF), write(multiplexer, 0x190))
    assert is_refused(bench, multiplexer, 0x191)


def test_bit_31_and_a_new_identifier_may_come_in_one_write(bench, multiplexer):
    configure(bench, write(multiplexer, 0x190 | OFF), write(multiplexer, 0x190))


@pytest.mark.parametrize("record", [RPDO, TPDO])
def test_the_profile_says_whether_it_takes_two(bench_of, record):
    bench = bench_of(strict_cob_id=True)
    assert is_refused(bench, record, 0x190 | OFF)
    configure(bench, write(record, FREE[record] | OFF), write(record, 0x190 | OFF))


def test_the_same_value_again_is_accepted(bench, multiplexer):
    configure(bench, write(multiplexer, FREE[multiplexer]))


@pytest.mark.parametrize("identifier", RESTRICTED)
def test_an_identifier_of_another_service_is_refused(bench, multiplexer, identifier):
    configure(bench, write(multiplexer, identifier | OFF))
    assert is_refused(bench, multiplexer, identifier)


@pytest.mark.parametrize("identifier", UNRESTRICTED)
def test_every_other_identifier_is_accepted(bench, multiplexer, identifier):
    configure(bench, write(multiplexer, identifier | OFF), write(multiplexer, identifier))


@pytest.mark.parametrize("bit", [11, 15, 28, 29])
@pytest.mark.parametrize("off", [0, OFF])
def test_identifiers_have_eleven_bits(bench, multiplexer, bit, off):
    configure(bench, write(multiplexer, FREE[multiplexer] | OFF))
    assert is_refused(bench, multiplexer, FREE[multiplexer] | 1 << bit | off)


def test_bit_30_of_an_rpdo_stays_as_the_dictionary_has_it(bench):
    configure(bench, MAPPED, COUNTED, write("021401", 0x405))
    assert bench.send("605#4002140100000000") == ["585#4302140105040040"]


def test_the_profile_says_whether_it_has_to_be_written_right(bench_of):
    bench = bench_of(strict_cob_id=True)
    assert is_refused(bench, "021401", 0x405)
    configure(bench, MAPPED, COUNTED, write("021401", 0x405 | 1 << 30))


def test_bit_30_of_a_tpdo_changes_while_it_is_off_only(bench):
    assert is_refused(bench, TPDO, 0x185 | 1 << 30)
    configure(bench, write(TPDO, 0x185 | OFF), write(TPDO, 0x185 | 1 << 30))


def test_bit_30_of_an_emergency_is_always_0(bench):
    configure(bench, write(EMCY, 0x85 | OFF))
    assert is_refused(bench, EMCY, 0x85 | 1 << 30)


@pytest.mark.spec("T-111")
@pytest.mark.parametrize("identifier", RESTRICTED)
def test_sync_does_not_come_on_an_identifier_of_another_service(bench, identifier):
    assert is_refused(bench, SYNC, identifier)


@pytest.mark.spec("T-111")
@pytest.mark.parametrize("identifier", UNRESTRICTED)
def test_sync_comes_on_any_other_identifier(bench, identifier):
    configure(bench, write(SYNC, identifier), "605#2F00180201000000")  # TPDO 1 with every SYNC
    bench.send("000#0105")
    assert "185#" in [frame[:4] for frame in bench.send(f"{identifier:03X}#")]


@pytest.mark.spec("T-019", "T-111")
@pytest.mark.parametrize("bit", [11, 16, 28, 29, 30, 31])
def test_sync_is_not_produced_and_has_eleven_bits(bench, bit):
    assert is_refused(bench, SYNC, 0x80 | 1 << bit)
