import pytest

from canopen_twins.devices.charger.model.charger import Key
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import (
    NEXT,
    ReleaseEvent,
    ReleaseSource,
    ReleaseState,
)

BUSES = [ReleaseSource.CANOPEN, ReleaseSource.ETHERNET]
OTHERS = [ReleaseSource.HMI, ReleaseSource.ANALOG, ReleaseSource.AUTOSTART]
SOURCES = [*BUSES, *OTHERS]


def test_every_state_has_a_row_and_a_way_out():
    assert set(NEXT) == set(ReleaseState)
    assert all(NEXT.values())


@pytest.mark.parametrize("state", ReleaseState)
def test_an_error_leads_to_fault_from_everywhere(state):
    assert NEXT[state].get(ReleaseEvent.TRIPPED, state) is ReleaseState.FAULT


def test_only_clearing_leads_out_of_fault_and_releases_nothing():
    assert NEXT[ReleaseState.FAULT] == {ReleaseEvent.CLEARED: ReleaseState.LOCKED}


@pytest.mark.spec("C-130")
@pytest.mark.parametrize(
    ("software", "hardware", "state"),
    [
        (False, False, ReleaseState.LOCKED),
        (False, True, ReleaseState.LOCKED),
        (True, False, ReleaseState.ARMED),
        (True, True, ReleaseState.ON),
    ],
)
def test_high_voltage_needs_both_releases(charger, software, hardware, state):
    charger.surround(hardware_release=hardware)
    if software:
        charger.grant(ReleaseSource.CANOPEN)
    assert charger.release.state is state
    assert charger.charging_active is (software and hardware)


@pytest.mark.spec("C-130")
def test_the_order_of_the_two_releases_does_not_matter(charger):
    charger.surround(hardware_release=False)
    charger.grant(ReleaseSource.CANOPEN)
    charger.surround(hardware_release=True)
    assert charger.charging_active


@pytest.mark.spec("C-131", "C-133", "C-134", "C-135", "C-136")
@pytest.mark.parametrize("enabled", SOURCES)
@pytest.mark.parametrize("source", SOURCES)
def test_only_an_enabled_source_can_release(make, enabled, source):
    charger = make(release_mode=enabled.value & ~ReleaseSource.AUTOSTART)
    charger.write(Parameter.RELEASE_MODE, enabled.value)
    charger.grant(source)
    assert charger.release.software is (source is enabled)


@pytest.mark.spec("C-131")
def test_the_factory_setting_is_a_release_by_the_hmi_alone(make):
    charger = make(release_mode=4)
    charger.grant(ReleaseSource.CANOPEN)
    assert not charger.release.software
    charger.press(Key.ON)
    assert charger.release.software


@pytest.mark.spec("C-131")
def test_the_last_of_several_sources_wins(make):
    charger = make(release_mode=(ReleaseSource.HMI | ReleaseSource.CANOPEN).value)
    charger.grant(ReleaseSource.CANOPEN)
    charger.press(Key.OFF)
    assert not charger.release.software
    charger.press(Key.ON)
    charger.revoke(ReleaseSource.CANOPEN)
    assert not charger.release.software


@pytest.mark.spec("C-135")
def test_without_its_bit_the_bus_can_not_take_a_release_away_either(make):
    charger = make(release_mode=ReleaseSource.HMI.value)
    charger.press(Key.ON)
    charger.revoke(ReleaseSource.CANOPEN)
    assert charger.release.software


@pytest.mark.spec("C-132")
@pytest.mark.parametrize("bit", [0, 1])
def test_autostart_releases_at_the_start(make, bit):
    assert make(release_mode=bit).charging_active is bool(bit)


@pytest.mark.spec("C-132")
def test_autostart_that_is_switched_on_later_acts_at_the_next_start(charger):
    charger.write(Parameter.RELEASE_MODE, 1)
    charger.step(1.0)
    assert not charger.release.software
    charger.restart({Parameter.RELEASE_MODE: 1})
    assert charger.release.software


@pytest.mark.spec("C-131")
def test_a_release_ends_with_the_bit_of_its_source(make):
    charger = make(release_mode=(ReleaseSource.HMI | ReleaseSource.CANOPEN).value)
    charger.grant(ReleaseSource.CANOPEN)
    charger.write(Parameter.RELEASE_MODE, ReleaseSource.CANOPEN.value)
    assert charger.release.software
    charger.write(Parameter.RELEASE_MODE, ReleaseSource.HMI.value)
    assert not charger.release.software


@pytest.mark.spec("C-133")
def test_the_analog_setpoint_releases_with_hysteresis(make):
    charger = make(release_mode=ReleaseSource.ANALOG.value, analog_setpoint=2)
    told = []
    for level in (0.0, 1.5, 2.0, 2.1, 1.5, 1.0, 0.9, 1.5):
        charger.surround(analog=level)
        charger.step(0.01)
        told.append(charger.release.software)
    assert told == [False, False, False, True, True, True, False, False]


@pytest.mark.spec("C-133")
@pytest.mark.parametrize(
    ("parameter", "value"), [(Parameter.ANALOG_SETPOINT, 0), (Parameter.RELEASE_MODE, 4)]
)
def test_an_analog_release_ends_with_the_interface_or_its_bit(make, parameter, value):
    charger = make(release_mode=ReleaseSource.ANALOG.value, analog_setpoint=1)
    charger.surround(analog=50.0)
    charger.step(0.01)
    assert charger.release.software
    charger.write(parameter, value)
    charger.step(0.01)
    assert not charger.release.software


@pytest.mark.spec("C-142")
def test_an_open_hardware_release_is_off_at_once_and_a_new_ramp_afterwards(running):
    running.surround(hardware_release=False)
    assert running.release.state is ReleaseState.ARMED
    assert not running.charging_active
    running.step(2.0)
    assert running.charging.output.voltage == 0
    running.surround(hardware_release=True)
    running.step(0.25)
    assert running.charging.output.voltage == pytest.approx(10000)


@pytest.mark.spec("C-120", "C-167")
def test_the_keyboard_lock_stops_the_keypad_but_not_the_touch_screen(make):
    charger = make(release_mode=ReleaseSource.HMI.value, keyboard_lock=0)
    charger.write(Parameter.KEYBOARD_LOCK, 1)
    charger.press(Key.ON)
    assert not charger.release.software
    charger.grant(ReleaseSource.HMI)
    charger.press(Key.OFF)
    assert charger.release.software


@pytest.mark.spec("C-120")
def test_the_keyboard_is_unlocked_after_every_restart(charger):
    charger.restart({Parameter.KEYBOARD_LOCK: 1})
    assert charger.parameters[Parameter.KEYBOARD_LOCK] == 0


@pytest.mark.spec("C-133")
def test_an_analog_setpoint_that_stands_there_releases_again_after_a_restart(make):
    values = {Parameter.RELEASE_MODE: ReleaseSource.ANALOG.value, Parameter.ANALOG_SETPOINT: 1}
    charger = make(release_mode=ReleaseSource.ANALOG.value, analog_setpoint=1)
    charger.surround(analog=50.0)
    charger.step(0.01)
    charger.restart(values)
    assert not charger.release.software
    charger.step(0.01)
    assert charger.release.software
