import pytest

from .declared import TEXT, U8, U32, bench_of, entry, record

UNUSED = record("1201", (U32, ""), (U32, ""), (U8, ""))
IN_USE = record("1201", (U32, "0x6E5"), (U32, "0x6F5"), (U8, 1))
READ = "4000100000000000"
VALUE = "4300100000000000"


@pytest.fixture
def unused(tmp_path):
    return bench_of(tmp_path, UNUSED)


@pytest.fixture
def second(unused):
    """Asks on 650h..., which 7.3.5 leaves free."""
    assert write(unused, 1, 0x680) == "60"
    assert write(unused, 2, 0x681) == "60"
    return unused


def write(bench, subindex, value):
    """The first byte of the answer, and of a refusal its code."""
    data = value.to_bytes(4, "little").hex().upper()
    (answer,) = bench.send(f"605#230112{subindex:02X}{data}")
    return answer[4:6] if answer[4:6] == "60" else answer[12:]


def test_a_server_without_identifiers_in_the_file_is_off(unused):
    assert unused.send("605#4001120100000000") == ["585#4301120100000080"]
    assert unused.send("605#4001120200000000") == ["585#4301120200000080"]
    assert unused.send("000#") == []


def test_a_server_is_there_once_both_identifiers_are(unused):
    write(unused, 1, 0x680)
    assert unused.send(f"680#{READ}") == []
    write(unused, 2, 0x681)
    assert unused.send(f"680#{READ}") == [f"681#{VALUE}"]


def test_the_identifiers_of_the_file_are_in_force(tmp_path):
    assert bench_of(tmp_path, IN_USE).send(f"6E5#{READ}") == [f"6F5#{VALUE}"]


def test_the_first_server_answers_as_before(second):
    assert second.send(f"605#{READ}") == [f"585#{VALUE}"]


def test_identifiers_stay_while_the_server_is_there(second):
    assert write(second, 1, 0x682) == "30000906"
    assert write(second, 2, 0x682) == "30000906"
    assert write(second, 1, 0x680) == "60"
    assert write(second, 2, 0x80000681) == "60"
    assert write(second, 1, 0x682) == "60"
    assert second.send(f"680#{READ}") == second.send(f"682#{READ}") == []


@pytest.mark.parametrize("value", [0x601, 0x5FF, 0x000, 0x7E5, 0x20000680, 0x00000800])
def test_an_identifier_of_another_service_is_refused(unused, value):
    assert write(unused, 1, value) == "30000906"


def test_what_the_file_has_can_be_switched_off_and_on(tmp_path):
    file = record("1201", (U32, "$NODEID+0x80000640"), (U32, "$NODEID+0x800005C0"))
    bench = bench_of(tmp_path, file)
    assert (write(bench, 1, 0x645), write(bench, 2, 0x5C5)) == ("60", "60")
    assert bench.send(f"645#{READ}") == [f"5C5#{VALUE}"]
    assert write(bench, 1, 0x646) == "30000906"


def test_each_server_has_a_transfer_of_its_own(tmp_path):
    bench = bench_of(tmp_path, IN_USE + entry("2002", TEXT, "ABCDEFGHI"))
    assert bench.send("605#4002200000000000") == ["585#4102200009000000"]
    assert bench.send("6E5#4002200000000000") == ["6F5#4102200009000000"]
    assert bench.send("605#6000000000000000") == ["585#0041424344454647"]
    assert bench.send(f"6E5#{READ}") == [f"6F5#{VALUE}"]
    assert bench.send("605#7000000000000000") == ["585#1B48490000000000"]


def test_refusals_go_to_the_client_that_asked(second):
    assert second.send("680#4000300000000000") == ["681#8000300000000206"]


def test_a_server_is_silent_in_stopped(second):
    second.send("000#0205")
    assert second.send(f"680#{READ}") == []


def test_further_servers_need_not_be_numbered_without_gaps(tmp_path):
    both = record("127F", (U32, "0x6E5"), (U32, "0x6F5")) + UNUSED
    assert bench_of(tmp_path, both).send(f"6E5#{READ}") == [f"6F5#{VALUE}"]
