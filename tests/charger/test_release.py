import pytest
from charger_bus import START, aborted, put, release, status, value

from canopen_twins import Bench


def command(bench, byte):
    """Write 0x6200:01 by hand."""
    return bench.send(f"663#2F006201{byte:02X}000000")


CONFIRMED = ["5E3#6000620100000000"]


@pytest.mark.spec("C-137", "C-138", "A-45")
@pytest.mark.parametrize("state", [START, "000#8063"])
def test_a_release_by_sdo_works_in_both_states(quiet, state):
    put(quiet, {0x02: 8})
    quiet.send(state)
    assert command(quiet, 0x0F) == CONFIRMED
    assert status(quiet) == 0x29
    assert command(quiet, 0x00) == CONFIRMED
    assert status(quiet) == 0x00


@pytest.mark.spec("C-137", "A-45")
@pytest.mark.parametrize("byte", [0x01, 0x0E, 0x10, 0xFF])
def test_another_value_by_sdo_is_refused_and_changes_nothing(on, byte):
    assert aborted(command(on, byte)) == (0x6200, 1, 0x06090030)
    assert status(on) == 0x29


@pytest.mark.spec("C-135", "A-46")
def test_without_the_bit_of_canopen_it_is_confirmed_without_effect(quiet):
    assert command(quiet, 0x0F) == CONFIRMED
    assert status(quiet) == 0x00
    quiet.inject("hmi_on")
    assert command(quiet, 0x00) == CONFIRMED
    assert status(quiet) == 0x29


@pytest.mark.spec("C-130", "C-142", "C-145", "A-44", "A-47")
def test_high_voltage_wants_both_releases(quiet):
    quiet.inject("hardware_release_lost")
    release(quiet)
    assert (status(quiet), value(quiet, 1, 0x6401)) == (0x20, 0)
    quiet.clear("hardware_release_lost")
    assert status(quiet) == 0x29
    quiet.run(0.5)
    assert value(quiet, 1, 0x6401) == 20_000
    quiet.inject("hardware_release_lost")
    assert status(quiet) == 0x20
    quiet.run(2.0)
    assert value(quiet, 1, 0x6401) == 0


@pytest.mark.spec("C-131", "C-134", "A-40")
@pytest.mark.parametrize("at", ["keypad", "touch"])
def test_the_operator_releases_and_locks(quiet, at):
    quiet.inject("hmi_on", at=at)
    assert status(quiet) == 0x29
    quiet.inject("hmi_off", at=at)
    assert status(quiet) == 0x00
    put(quiet, {0x02: 8})
    quiet.inject("hmi_on", at=at)
    assert status(quiet) == 0x00


@pytest.mark.spec("C-120", "C-167")
def test_the_keyboard_lock_stops_the_keypad_and_not_the_touch_screen(quiet):
    put(quiet, {0x1C: 1})
    quiet.inject("hmi_on")
    assert status(quiet) == 0x00
    quiet.inject("hmi_on", at="touch")
    assert status(quiet) == 0x29
    quiet.inject("hmi_off")
    assert status(quiet) == 0x29


@pytest.mark.spec("C-133", "C-166", "A-63")
def test_the_analog_input_releases_and_gives_the_setpoint(quiet):
    put(quiet, {0x02: 2, 0x03: 2})
    quiet.inject("analog", percent=50)
    quiet.run(1.0)
    assert (status(quiet), value(quiet, 1, 0x6401)) == (0x29, 15_000)
    quiet.clear("analog")
    quiet.run(2.0)
    assert (status(quiet), value(quiet, 1, 0x6401)) == (0x00, 0)


@pytest.mark.spec("C-132", "A-41")
def test_autostart_is_for_the_next_power_up(quiet):
    put(quiet, {0x02: 1})
    assert status(quiet) == 0x00
    quiet.send("663#2310100173617665")
    quiet.power_off()
    quiet.power_on()
    assert status(quiet) == 0x29


@pytest.mark.spec("C-139", "C-140", "C-141", "A-42")
def test_the_timeout_counts_from_the_last_release_and_says_nothing(quiet):
    put(quiet, {0x02: 8, 0x04: 1000})
    for _ in range(5):
        quiet.send(START)
        quiet.send("263#0F")
        quiet.run(0.9)
    assert status(quiet) == 0x29
    quiet.run(0.1)
    assert status(quiet) == 0x00
    assert not [frame for frame in quiet.sent if frame.startswith("0E3#")]
    quiet.send("263#0F")
    assert status(quiet) == 0x29


@pytest.mark.spec("C-140")
@pytest.mark.parametrize(
    ("written", "read"), [(0, 0), (1, 0), (499, 0), (500, 500), (60_000, 60_000)]
)
def test_a_timeout_that_is_too_short_is_none(quiet, written, read):
    put(quiet, {0x04: written})
    assert value(quiet, 0x04) == read
    assert aborted(quiet.send("663#2B02200461EA0000")) == (0x2002, 4, 0x06090031)


@pytest.mark.spec("C-145", "C-178", "A-60")
def test_bit_6_says_that_a_calibration_runs_or_waits(on):
    put(on, {0x19: 2})
    assert status(on) == 0x69
    command(on, 0x00)
    assert status(on) == 0x40
    put(on, {0x19: 0})
    assert status(on) == 0x00


@pytest.mark.spec("C-145", "C-197", "A-43", "A-44")
def test_discharging_alone_is_high_voltage_too():
    bench = Bench("charger", variant="A")
    put(bench, {0x22: 1, 0x27: 0})
    assert status(bench) == 0x11
    put(bench, {0x27: 1})
    assert status(bench) == 0x00
    release(bench)
    assert status(bench) == 0x39
    bench.inject("discharging_release_lost")
    assert status(bench) == 0x29
    put(bench, {0x22: 0})
    bench.clear("discharging_release_lost")
    assert status(bench) == 0x29
