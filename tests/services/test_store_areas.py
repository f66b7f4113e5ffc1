import pytest
from probe import configure

from .declared import BASE, DOMAIN, U8, U16, U32, bench_of, entry, record

STORE = record("1010", *[(U32, "")] * 4) + record("1011", *[(U32, "")] * 4)
APPLICATION = entry("6000", U16, 1)
NAMES = [(0x1017, 0), (0x2000, 0), (0x6000, 0)]
CHANGES = ["605#2B171000E8030000", "605#2B00200009000000", "605#2B00600009000000"]
CHANGED, DEFAULTS = [1000, 9, 9], [0, 7, 1]


@pytest.fixture
def bench(tmp_path):
    return bench_of(tmp_path, STORE + APPLICATION)


@pytest.fixture
def changed(bench):
    configure(bench, *CHANGES)
    return bench


def values(bench):
    return [bench.sdo[index].raw for index, _ in NAMES]


def save(subindex):
    return f"605#231010{subindex:02X}73617665"


def load(subindex):
    return f"605#231110{subindex:02X}6C6F6164"


@pytest.mark.parametrize("subindex", [1, 2, 3, 4])
@pytest.mark.parametrize("index", ["10", "11"])
def test_every_area_is_stored_on_command(bench, index, subindex):
    answer = f"585#43{index}10{subindex:02X}01000000"
    assert bench.send(f"605#40{index}10{subindex:02X}00000000") == [answer]


@pytest.mark.parametrize(
    ("subindex", "stored"), [(1, CHANGED), (2, [1000, 7, 1]), (3, [0, 7, 9]), (4, [0, 9, 1])]
)
def test_an_area_is_stored_and_the_others_are_not(changed, subindex, stored):
    configure(changed, save(subindex))
    changed.send("000#8105")
    assert values(changed) == stored


def test_areas_are_stored_one_after_the_other(changed):
    configure(changed, save(2), save(4))
    changed.send("000#8105")
    assert values(changed) == [1000, 9, 1]


@pytest.mark.parametrize(
    ("subindex", "left"), [(1, DEFAULTS), (2, [0, 9, 9]), (3, [1000, 9, 1]), (4, [1000, 7, 9])]
)
def test_an_area_is_restored_with_the_next_reset(changed, subindex, left):
    configure(changed, save(1), load(subindex))
    assert values(changed) == CHANGED
    changed.send("000#8105")
    assert values(changed) == left


def test_what_is_restored_of_the_communication_is_in_force_after_its_reset(changed):
    configure(changed, save(1), load(2))
    changed.send("000#8205")
    assert values(changed) == [0, 9, 9]


@pytest.mark.parametrize("subindex", [1, 2, 3, 4])
def test_without_its_signature_nothing_is_stored(changed, subindex):
    answer = f"585#801010{subindex:02X}20000008"
    assert changed.send(f"605#231010{subindex:02X}6C6F6164") == [answer]
    changed.send("000#8105")
    assert values(changed) == DEFAULTS


def test_pdos_come_back_as_they_were_stored(bench):
    configure(
        bench,
        "605#2300180185010080",  # off
        "605#2F001A0000000000",
        "605#23001A0110000020",  # 2000h in the place of 2001h
        "605#2F001A0001000000",
        "605#2300180186010000",
        "605#2F001802FF000000",
        save(1),
    )
    bench.send("000#8105")
    assert bench.send("000#0105") == ["186#0700"]


def test_a_domain_is_no_parameter(tmp_path):
    bench = bench_of(tmp_path, STORE + entry("2002", DOMAIN, "0102"))
    configure(bench, save(1))
    kept = bench.device.memory.content["parameters"]
    assert ("2000:00" in kept, "2002:00" in kept) == (True, False)


VERIFY = record("1020", (U32, ""), (U32, ""))
DATE, TIME = "605#2320100139300000", "605#232010020A000000"


@pytest.fixture
def verified(tmp_path):
    bench = bench_of(tmp_path, STORE + VERIFY + entry("2002", U8, 0))
    configure(bench, "605#2B171000E8030000", DATE, TIME)
    return bench


def signature(bench):
    return [bench.sdo[0x1020][sub].raw for sub in (1, 2)]


def test_the_time_of_the_configuration_is_kept_with_it(verified):
    configure(verified, save(1))
    verified.send("000#8105")
    assert signature(verified) == [12345, 10]


@pytest.mark.parametrize("change", ["605#2B17100064000000", "605#2F02200001000000"])
def test_a_change_of_the_configuration_zeroes_it(verified, change):
    configure(verified, change)
    assert signature(verified) == [0, 0]


@pytest.mark.parametrize("same", ["605#2B171000E8030000", "605#2B00200009000000", "000#0105"])
def test_what_changes_no_configuration_does_not(verified, same):
    verified.send(same)
    assert signature(verified) == [12345, 10]


def test_a_change_that_is_refused_does_not(tmp_path):
    narrow = entry("2002", U8, 0, more="LowLimit=0\nHighLimit=3\n")
    bench = bench_of(tmp_path, VERIFY + narrow)
    configure(bench, DATE, TIME)
    assert bench.send("605#2F02200004000000") == ["585#8002200031000906"]
    assert signature(bench) == [12345, 10]


def test_the_file_can_be_read_from_the_device(tmp_path):
    more = entry("1021", DOMAIN, access="ro") + entry("1022", U8, "")
    bench = bench_of(tmp_path, more)
    assert bench.sdo[0x1021].raw == (BASE + more).encode()
    with bench.sdo[0x1021].open("rb", block_transfer=True) as file:
        assert file.read() == (BASE + more).encode()
    assert bench.sdo[0x1022].raw == 0


def test_a_file_that_has_gone_cannot(tmp_path):
    bench = bench_of(tmp_path, entry("1021", DOMAIN, access="ro"))
    (tmp_path / "drive.eds").unlink()
    assert bench.send("605#4021100000000000") == ["585#8021100024000008"]
