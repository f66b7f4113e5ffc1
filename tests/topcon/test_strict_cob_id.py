import pytest

from canopen_twins import Bench

from .bus import START

LENIENT, STRICT = [{}, {"strict_cobid": False}], {"strict_cobid": True}


def write(bench, index, value):
    return bench.send(f"605#23{index[2:]}{index[:2]}01{value}")


def accepted(index):
    return [f"585#60{index[2:]}{index[:2]}0100000000"]


def refused(index):
    return [f"585#80{index[2:]}{index[:2]}0130000906"]


@pytest.mark.spec("A-26", "A-28")
@pytest.mark.parametrize("settings", LENIENT)
def test_one_write_may_set_bit_31_and_change_the_identifier(settings):
    bench = Bench("topcon", node_id=5, **settings)
    assert write(bench, "1400", "06020080") == accepted("1400")
    assert bench.send("605#4000140100000000") == ["585#43001401060200C0"]  # bit 30 reads 1
    assert write(bench, "1400", "06020000") == accepted("1400")
    assert bench.send("605#4000140100000000") == ["585#4300140106020040"]
    assert write(bench, "1800", "86010080") == accepted("1800")


@pytest.mark.spec("A-28")
@pytest.mark.parametrize("index", ["1400", "1800"])
def test_a_strict_card_wants_bit_31_set_by_a_write_of_its_own(index):
    bench = Bench("topcon", node_id=5, **STRICT)
    old, new, bit_30 = {"1400": ("0502", "0602", 4), "1800": ("8501", "8601", 0)}[index]
    assert write(bench, index, f"{new}00{bit_30 + 8:X}0") == refused(index)
    for value in (f"{old}00{bit_30 + 8:X}0", f"{new}00{bit_30 + 8:X}0", f"{new}00{bit_30}0"):
        assert write(bench, index, value) == accepted(index), value


@pytest.mark.spec("A-26")
@pytest.mark.parametrize("value", ["05020000", "05020080", "06020000", "06020080"])
@pytest.mark.parametrize("off_before", [False, True])
def test_a_strict_card_wants_bit_30_of_an_rpdo_set(value, off_before):
    bench = Bench("topcon", node_id=5, **STRICT)
    if off_before:
        write(bench, "1400", "050200C0")
    assert write(bench, "1400", value) == refused("1400")
    write(bench, "1400", "05020040")
    bench.send(START)
    bench.send("205#E803")
    assert bench.sdo["Voltage reference"].raw == 1000
