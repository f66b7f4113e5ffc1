from shutil import rmtree

import pytest

from canopen_twins import Bench, UserError
from canopen_twins.slave.memory import Memory

from .bus import BOOT_UP, START, read, word


@pytest.mark.spec("G-005")
def test_a_change_acts_after_saving_and_a_reset_of_that_unit(configured):
    bench = configured()
    bench.device.governor["CanOpenSendStatus"] = 1
    bench.device.gateway[429] = 500
    assert bench.device.governor[14402] == 1
    bench.device.governor.save()
    bench.device.gateway.save()
    bench.run(1.0)
    assert (read(bench, 0x2000), read(bench, 0x1017)) == (6, 1000)
    bench.device.governor.reset()
    bench.run(0.5)
    assert (read(bench, 0x2000), read(bench, 0x1017)) == (7, 1000)
    bench.device.gateway.reset()
    bench.run(0.5)
    assert (read(bench, 0x2000), read(bench, 0x1017)) == (7, 500)


@pytest.mark.spec("G-005")
def test_without_saving_it_is_lost(bench):
    bench.device.gateway[429] = 500
    bench.device.gateway.reset()
    bench.run(0.5)
    assert (bench.device.gateway[429], read(bench, 0x1017)) == (1000, 1000)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        (427, 128, "gateway 427 CanOpenMyNodeID: 128 is not in 1..127"),
        ("CanOpenMyNodeId", 5, "did you mean 'CanOpenMyNodeID'?"),
        (2405, 1, "is only shown"),
        (16480, 1, "the gateway has no parameter 16480"),
    ],
)
def test_a_wrong_change_is_refused_in_one_line(bench, key, value, told):
    with pytest.raises(UserError) as refusal:
        bench.device.gateway[key] = value
    assert told in str(refusal.value)


def test_measurements_are_read_in_their_units(bench):
    bench.run(20.0)
    assert round(bench.device.governor["Speed"]) == 1500
    assert bench.device.gateway["PowerSupply"] == 24.0
    assert bench.device.gateway[12403] == 1


@pytest.mark.spec("G-183", "G-184", "G-140")
@pytest.mark.parametrize("unit", ["governor", "gateway"])
def test_clearing_in_one_unit_clears_in_the_other(configured, unit):
    bench = configured()
    bench.device.governor.reset()
    bench.run(0.5)
    assert word(bench) == 0x0001
    getattr(bench.device, unit).clear_errors()
    bench.run(0.05)
    assert word(bench) == 0


@pytest.mark.spec("G-200", "G-220")
def test_a_pc_is_known_once_it_is_connected(bench):
    bench.device.gateway.connect(node=3, identifier=4711)
    assert (bench.device.gateway[2425], bench.device.gateway[3850]) == (8, 4711)
    bench.device.gateway.save()
    assert bench.device.gateway[3851] == 4711


@pytest.mark.spec("G-181", "G-182")
def test_counters_survive_and_present_errors_do_not(tmp_path):
    file = tmp_path / "memory.json"
    bench = Bench("gateway")
    bench.power_off()
    bench.device.memory = Memory(file)
    bench.power_on()
    bench.run(0.5)
    for _ in range(3):
        bench.inject("supply", volts=7, unit="both")
        bench.run(0.1)
        bench.clear("supply")
        bench.run(0.1)
    assert bench.device.gateway[3185] == 3
    other = Bench("gateway")
    other.power_off()
    other.device.memory = Memory(file)
    other.power_on()
    other.run(0.5)
    assert (other.device.gateway[3185], other.device.gateway[3085]) == (3, 0)
    other.device.gateway.clear_error_memory()
    assert Memory(file).load("gateway")["errors"] == {}
    assert (other.device.gateway[3185], other.device.governor[3185]) == (0, 3)


def test_what_dcdesk_has_saved_comes_before_the_configuration(configured):
    bench = configured(gateway={429: 200, 428: 9})
    bench.device.gateway[429] = 1000  # as from the factory
    bench.device.gateway.save()
    bench.power_off()
    bench.power_on()
    bench.run(0.5)
    assert (read(bench, 0x1017), bench.device.gateway[428]) == (1000, 9)


def test_that_holds_even_if_it_is_as_from_the_factory(configured):
    bench = configured(gateway={429: 200})
    bench.device.gateway[429] = 1000
    bench.device.gateway.save()
    bench.power_off()
    bench.power_on()
    bench.run(0.5)
    assert read(bench, 0x1017) == 1000


def test_without_it_the_configuration_of_the_moment_holds(configured, tmp_path):
    bench = configured(gateway={429: 200})
    bench.inject("supply")  # counted, so that the memory has something
    bench.run(0.1)
    bench.clear()
    bench.power_off()
    (tmp_path / "configuration.yaml").write_text("version: 1\ngateway: {429: 300}\n")
    bench.power_on()
    bench.run(0.5)
    assert (read(bench, 0x1017), bench.device.gateway[3185]) == (300, 1)


def test_a_memory_of_something_else_is_refused(bench):
    bench.power_off()
    bench.device.memory.store("gateway", {"parameters": {"427": 200}})
    with pytest.raises(UserError, match=r"200 is not in 1..127"):
        bench.power_on()


def test_a_memory_that_cannot_be_written_is_reported(bench, caplog, tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    bench.power_off()
    bench.device.memory = Memory(folder / "memory.json")
    bench.power_on()
    bench.run(0.5)
    rmtree(folder)
    bench.device.gateway.save()
    assert "the memory cannot be written: " in caplog.text


def test_by_hand_both_units_are_reset_at_one_moment(configured):
    bench = configured({16460: 0, 16472: 0, 14401: 0}, {429: 0})
    bench.send(START)
    device = bench.device
    device.governor.reset()
    device.gateway.reset()
    assert bench.run(0.5) == [BOOT_UP]
    assert word(bench) == 0
