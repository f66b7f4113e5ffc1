import pytest
from probe import configure

from .declared import U16, U32, bench_of, entry, record

NO_REGISTER = """[1001]
ParameterName=Error register
ObjectType=0x7
DataType=0x0005
AccessType=ro
DefaultValue=0x00
PDOMapping=0
"""
PASSIVE, BACK = "085#2081110000000000", "085#0000000000000000"
INHIBIT = entry("1015", U16, 1000)  # 100 ms


@pytest.fixture
def bench(tmp_path):
    return bench_of(tmp_path, INHIBIT + entry("1014", U32, "$NODEID+0x80"))


def flicker(bench):
    """An error that comes and goes; what is sent at once."""
    start = len(bench.sent)
    bench.inject("error_passive", seconds=0.0)
    bench.clear("error_passive")
    return bench.sent[start:]


def test_without_an_error_register_its_byte_is_0(tmp_path):
    bench = bench_of(tmp_path, old=NO_REGISTER)
    assert flicker(bench) == ["085#2081000000000000", BACK]
    assert bench.send("605#4001100000000000") == ["585#8001100000000206"]


def test_between_two_messages_passes_the_inhibit_time(bench):
    assert flicker(bench) == [PASSIVE]
    assert bench.run(0.0999) == []
    assert bench.run(0.0002) == [BACK]
    assert flicker(bench) == []
    assert bench.run(0.0997) == []
    assert bench.run(0.0004) == [PASSIVE]
    assert bench.run(1.0) == [BACK]
    assert flicker(bench) == [PASSIVE]


def test_an_inhibit_time_of_0_is_none(bench):
    configure(bench, "605#2B15100000000000")
    assert flicker(bench) == [PASSIVE, BACK]


def test_what_waits_outlives_a_reset_of_the_communication(bench):
    flicker(bench)
    assert bench.send("000#8205") == ["705#00", BACK]


def test_what_waits_in_stopped_is_told_after_it(bench):
    flicker(bench)
    bench.send("000#0205")
    assert bench.run(1.0) == []
    assert bench.send("000#8005") == [BACK]


def test_emergencies_that_are_off_do_not_wait(bench):
    configure(bench, "605#2314100085000080")
    assert flicker(bench) == []
    configure(bench, "605#2314100085000000")
    assert bench.run(1.0) == []


@pytest.mark.parametrize("value", ["86000000", "85000040", "00000000", "00080000"])
def test_an_identifier_changes_while_emergencies_are_off(bench, value):
    assert bench.send(f"605#23141000{value}") == ["585#8014100030000906"]


def test_a_new_identifier_is_used(bench):
    configure(bench, "605#2314100085000080", "605#23141000A5000000")
    assert flicker(bench) == ["0A5#2081110000000000"]


def test_a_history_with_gaps_has_each_error_at_its_age(tmp_path):
    history = "[1003]\nParameterName=History\nObjectType=0x8\nSubNumber=3\n"
    subs = [entry("1003sub0", 5, 0), entry("1003sub1", U32), entry("1003sub3", U32)]
    bench = bench_of(tmp_path, history + "".join(subs))
    for fault in ("error_passive", "bus_off", "error_passive"):
        bench.inject(fault)
        bench.clear(fault)
        bench.run(0.1)
    assert bench.send("605#4003100000000000") == ["585#4F03100003000000"]
    assert bench.send("605#4003100100000000") == ["585#4303100120810000"]
    assert bench.send("605#4003100200000000") == ["585#8003100211000906"]
    assert bench.send("605#4003100300000000") == ["585#4303100320810000"]


CONSUMER = record("1028", *[(U32, "")] * 7)


@pytest.fixture
def hearing(tmp_path):
    return bench_of(tmp_path, CONSUMER)


def test_no_node_is_heard_unless_its_identifier_is_given(hearing):
    assert hearing.send("605#4028100700000000") == ["585#4328100700000080"]
    hearing.send("087#1023010000000000")
    assert hearing.report == {}


def test_emergencies_of_a_node_are_heard(hearing):
    configure(hearing, "605#2328100787000000")
    hearing.send("087#1023010000000000")
    assert hearing.report == {"EMCY of node 7": "2310h"}
    hearing.send("000#0205")
    hearing.send("087#0000000000000000")
    assert hearing.report == {"EMCY of node 7": "2310h"}
    hearing.send("000#0105")
    hearing.send("087#00000000")
    assert hearing.report == {"EMCY of node 7": "2310h"}
    hearing.send("087#0000000000000000")
    assert hearing.report == {"EMCY of node 7": "0000h"}


def test_an_identifier_of_another_node_changes_while_it_is_off(hearing):
    configure(hearing, "605#2328100787000000")
    assert hearing.send("605#2328100788000000") == ["585#8028100730000906"]
    configure(hearing, "605#2328100787000080", "605#2328100788000000")
