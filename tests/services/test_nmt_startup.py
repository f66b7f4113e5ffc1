import pytest

from .declared import U32, bench_of, entry


def booted(folder, value):
    return bench_of(folder, entry("1F80", U32, value))


@pytest.mark.parametrize(
    ("value", "state"),
    [("0", "OPERATIONAL"), ("", "OPERATIONAL"), ("4", "PRE-OPERATIONAL"), ("8", "OPERATIONAL")],
)
def test_bit_2_says_whether_a_node_waits_for_the_master(tmp_path, value, state):
    bench = booted(tmp_path, value)
    assert (bench.state, bench.sent) == (state, ["705#00"])
    bench.send("000#8005")
    assert bench.state == "PRE-OPERATIONAL"
    bench.send("000#8205")
    assert bench.state == state


def test_a_file_without_a_start_up_waits(tmp_path):
    assert bench_of(tmp_path).state == "PRE-OPERATIONAL"


def test_pdos_go_out_right_after_the_boot_up(tmp_path):
    bench = bench_of(
        tmp_path,
        entry("1F80", U32, 0),
        "DefaultValue=1\nPDOMapping=0\n[1A00]",
        "DefaultValue=255\nPDOMapping=0\n[1A00]",
    )
    assert bench.sent == ["705#00", "185#0900"]


@pytest.mark.parametrize("value", [0, 4])
def test_the_start_up_can_be_written(tmp_path, value):
    bench = booted(tmp_path, 4)
    assert bench.send(f"605#23801F000{value}000000") == ["585#60801F0000000000"]


@pytest.mark.parametrize("value", ["01", "02", "05", "08", "10", "40"])
def test_what_only_a_master_knows_is_refused(tmp_path, value):
    bench = booted(tmp_path, 4)
    assert bench.send(f"605#23801F00{value}000000") == ["585#80801F0030000906"]
