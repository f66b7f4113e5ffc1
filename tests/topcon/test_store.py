import pytest

from canopen_twins import Bench

from .bus import RESET_COMMUNICATION, RESET_NODE, aborted, read, run, state_of_output

SAVE, SAVED = "605#2310100173617665", ["585#6010100100000000"]
STORED = {0x2010: 1001, 0x2011: 1002, 0x2012: 1003, 0x2013: 1004, 0x2030: 4001, 0x2031: 4002}
DEFAULTS = {0x2010: 0, 0x2011: 0, 0x2012: 4000, 0x2013: 0, 0x2030: 4400, 0x2031: 4400}
VOLATILE = {  # index, sub-index: written value, value after a reset
    (0x1005, 0): (0x85, 0x80),
    (0x1017, 0): (5000, 0),
    (0x1400, 1): (0xC0000205, 0x40000205),
    (0x1400, 2): (1, 254),
    (0x1403, 2): (0, 254),
    (0x1800, 1): (0x80000185, 0x185),
    (0x1800, 2): (240, 253),
    (0x1801, 1): (0x285, 0x80000285),
    (0x2100, 1): (0x42, 0),
}


def values(bench):
    return {index: bench.sdo[index].raw for index in STORED}


def change(bench):
    for index, value in STORED.items():
        bench.sdo[index].raw = value


def restart(bench, how):
    if how == "power":
        bench.power_off()
        bench.power_on()
    else:
        bench.send(how)


RESTARTS = pytest.mark.parametrize("how", [RESET_NODE, "power"])


@pytest.mark.spec("T-107", "A-20")
def test_the_object_says_that_it_stores_on_command(topcon):
    assert read(topcon, 0x1010) == ["585#4F10100001000000"]
    assert read(topcon, 0x1010, 1) == ["585#4310100101000000"]


@pytest.mark.spec("T-107", "T-108", "T-109", "A-21")
@RESTARTS
def test_saved_values_come_back(topcon, how):
    change(topcon)
    assert topcon.send(SAVE) == SAVED
    assert read(topcon, 0x1010, 1) == ["585#4310100101000000"]
    for index in STORED:
        topcon.sdo[index].raw = 7
    restart(topcon, how)
    assert values(topcon) == STORED


@pytest.mark.spec("T-012", "T-108", "A-42")
@RESTARTS
def test_values_that_were_not_saved_do_not(topcon, how):
    change(topcon)
    restart(topcon, how)
    assert values(topcon) == DEFAULTS


@pytest.mark.spec("T-109")
def test_the_last_save_counts(topcon):
    change(topcon)
    topcon.send(SAVE)
    topcon.sdo["Voltage reference"].raw = 5
    topcon.send(SAVE)
    restart(topcon, RESET_NODE)
    assert values(topcon) == {**STORED, 0x2010: 5}


@pytest.mark.spec("T-109")
@pytest.mark.parametrize(
    "signature",
    ["00000000", "01000000", "65766173", "73617600", "53415645", "6C6F6164", "FFFFFFFF"],
)
def test_any_other_signature_stores_nothing(topcon, signature):
    change(topcon)
    assert aborted(topcon.send(f"605#23101001{signature}")) == (0x1010, 1, 0x08000020)
    restart(topcon, "power")
    assert values(topcon) == DEFAULTS


@pytest.mark.spec("T-109", "A-21")
def test_a_reset_of_the_communication_does_not_touch_the_set_values(topcon):
    topcon.send(SAVE)
    change(topcon)
    topcon.send(RESET_COMMUNICATION)
    assert values(topcon) == STORED


@pytest.mark.spec("T-064", "T-108", "A-20")
@RESTARTS
@pytest.mark.parametrize("address", VOLATILE, ids=lambda at: f"{at[0]:04X}sub{at[1]}")
def test_nothing_else_is_stored(topcon, how, address):
    written, after = VOLATILE[address]
    entry = topcon.sdo.get_variable(*address)
    entry.raw = written
    assert entry.raw == written
    topcon.send(SAVE)
    restart(topcon, how)
    assert entry.raw == after


@pytest.mark.spec("T-108", "A-46")
@RESTARTS
def test_the_output_is_off_after_power_on_whatever_was_stored(topcon, how):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.send(SAVE)
    restart(topcon, how)
    topcon.run(1.0)
    assert topcon.sdo["Run command"].raw == 0
    assert state_of_output(topcon) == 0
    assert topcon.sdo["Voltage reference"].raw == 2000


@pytest.mark.spec("T-108", "A-42")
def test_stored_values_win_over_those_of_the_settings():
    bench = Bench("topcon", node_id=5, power_on_voltage=100)
    bench.send(SAVE)
    bench.power_off()
    bench.power_on(power_on_voltage=200)
    assert bench.sdo["Voltage reference"].raw == 100


@pytest.mark.spec("T-190", "T-108")
def test_a_stored_level_protects_from_power_on(topcon):
    topcon.sdo["Overvoltage level"].raw = 1000
    topcon.send(SAVE)
    topcon.power_off()
    topcon.set(load="battery 200 0.1")
    topcon.power_on()
    assert topcon.run(0.1) == ["085#0033053000000000"]
