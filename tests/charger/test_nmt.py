import pytest
from charger_bus import (
    ENTER_PREOP,
    RESET_COMMUNICATION,
    RESET_NODE,
    START,
    STOP,
    ask,
    put,
    release,
    restart,
    status,
    value,
)

from canopen_twins import Bench

BEAT = {START: "763#05", STOP: "763#04", ENTER_PREOP: "763#7F"}


def state(bench):
    """What the next heartbeat says."""
    beats = [frame for frame in bench.run(1.0) if frame.startswith("763#")]
    return beats[-1]


@pytest.mark.spec("C-010", "C-020")
def test_after_power_up_it_boots_and_stays_pre_operational(bench):
    assert bench.sent == ["763#00"]
    assert bench.run(10.0) == ["763#7F"] * 10


@pytest.mark.spec("C-004", "C-005", "C-006", "C-003")
@pytest.mark.parametrize("before", BEAT)
@pytest.mark.parametrize("command", BEAT)
def test_every_state_is_reached_from_every_other(bench, before, command):
    bench.send(before)
    bench.send(command)
    assert state(bench) == BEAT[command]


@pytest.mark.spec("C-009")
@pytest.mark.parametrize(
    ("frame", "obeyed"),
    [("000#0100", True), ("000#0163", True), ("000#0162", False), ("000#01E3", False)],
)
def test_only_its_own_id_and_0_are_meant(bench, frame, obeyed):
    assert (bench.send(frame) != []) is obeyed


@pytest.mark.spec("C-009")
@pytest.mark.parametrize("command", [0x00, 0x03, 0x7F, 0x83, 0xFF])
def test_an_unknown_command_has_no_effect(bench, command):
    bench.send(START)
    assert bench.send(f"000#{command:02X}63") == []
    assert state(bench) == "763#05"


@pytest.mark.spec("C-003", "A-25")
@pytest.mark.parametrize("rest", ["", "00", "AABB", "FFFFFFFFFFFF"])
def test_bytes_beyond_the_second_are_ignored(bench, rest):
    bench.send(START + rest)
    assert state(bench) == "763#05"


@pytest.mark.spec("C-003", "A-25")
def test_a_command_without_a_node_id_is_not_obeyed(bench):
    assert bench.send("000#01") == []
    assert bench.send("000#") == []


@pytest.mark.spec("C-007", "C-008")
@pytest.mark.parametrize("reset", [RESET_NODE, RESET_COMMUNICATION])
@pytest.mark.parametrize("before", BEAT)
def test_both_resets_boot_in_every_state(bench, reset, before):
    bench.send(before)
    assert bench.send(reset) == ["763#00"]
    assert state(bench) == "763#7F"


@pytest.mark.spec("C-007", "A-26")
@pytest.mark.parametrize("how", [RESET_NODE, "power"])
def test_a_reset_of_the_node_is_a_power_up(on, how):
    put(on, {0x1C: 1})
    on.inject("spark", slope=0.3)
    restart(on, how)
    on.run(1.0)
    assert status(on) == 0x00
    assert [value(on, sub) for sub in (0x02, 0x08, 0x1C)] == [4, 1500, 0]
    assert value(on, 0x08, 0x2001) == 0
    assert on.sdo[0x1017].raw == 1000


@pytest.mark.spec("C-007", "A-26", "A-41")
@pytest.mark.parametrize("how", [RESET_NODE, "power"])
def test_autostart_acts_at_both(quiet, how):
    put(quiet, {0x02: 9})
    quiet.send("663#2310100173617665")
    assert status(quiet) == 0x00
    restart(quiet, how)
    assert status(quiet) == 0x29


@pytest.mark.spec("C-008", "C-144", "A-26", "A-49")
def test_a_reset_of_the_communication_leaves_the_application_alone(on):
    put(on, {0x1C: 1, 0x01: 700})
    on.inject("spark", slope=0.3)
    on.send(RESET_COMMUNICATION)
    on.run(1.0)
    assert status(on) == 0x29
    assert [value(on, sub) for sub in (0x01, 0x02, 0x08, 0x1C)] == [700, 8, 20_000, 1]
    assert value(on, 0x08, 0x2001) == 1
    assert on.sdo[0x1017].raw == 1000


@pytest.mark.spec("C-144", "A-49")
@pytest.mark.parametrize("command", [STOP, ENTER_PREOP, RESET_COMMUNICATION])
def test_no_nmt_command_switches_high_voltage_off(on, command):
    on.send(START)
    on.send(command)
    on.run(60.0)
    assert on.device.report["voltage [V]"] == 20_000


@pytest.mark.spec("C-144", "C-139")
def test_of_a_dead_master_only_the_release_timeout_notices(bench):
    put(bench, {0x04: 2000})
    release(bench)
    bench.run(0.98)
    assert status(bench) == 0x29
    bench.run(0.02)
    assert status(bench) == 0x00


@pytest.mark.spec("C-011")
def test_a_stopped_node_is_silent_but_for_heartbeat_and_lss(bench):
    bench.send(STOP)
    bench.inject("error", key="hardware")
    assert ask(bench, 0x1000) == []
    assert bench.run(1.0) == ["763#04"]
    bench.send("7E5#0401000000000000")
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E63000000000000"]
    assert bench.send("263#0F") == []
    assert "0E3#005001010B000000" in bench.send(START)


@pytest.mark.spec("C-010")
def test_a_node_without_power_is_gone():
    bench = Bench("charger")
    bench.power_off()
    assert bench.run(5.0) == []
    assert ask(bench, 0x1000) == []
