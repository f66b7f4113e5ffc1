import pytest

from canopen_twins.devices.charger.model.output import Ramp
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource


def microamperes(charger):
    return charger.charging.output.current * 1e6


@pytest.mark.spec("C-157")
@pytest.mark.parametrize("ramp", [100, 500, 1234, 10000])
@pytest.mark.parametrize("voltage", [1500, 20000])
def test_switching_on_takes_the_ramp_time_whatever_the_step(make, switch_on, ramp, voltage):
    charger = make(ramp_time=ramp, voltage_setpoint=voltage)
    ticks = -(-ramp // 10)
    switch_on(charger, (ticks - 1) / 100)
    assert charger.charging.output.voltage < voltage
    charger.step(0.01)
    assert charger.charging.output.voltage == voltage


@pytest.mark.spec("C-157")
def test_a_new_setpoint_starts_a_new_ramp_from_where_the_last_one_was(make, switch_on):
    charger = make(voltage_setpoint=20000)
    switch_on(charger, 0.25)
    assert charger.charging.output.voltage == pytest.approx(10000)
    charger.write(Parameter.VOLTAGE_SETPOINT, 4000)
    charger.step(0.25)
    assert charger.charging.output.voltage == pytest.approx(7000)
    charger.step(0.25)
    assert charger.charging.output.voltage == 4000


@pytest.mark.spec("C-157")
def test_the_ramp_of_i_const_is_one_of_the_current(make, switch_on):
    charger = make(mode=4, current_setpoint=1000, voltage_setpoint=30000)
    switch_on(charger, 0.25)
    assert microamperes(charger) == pytest.approx(500)
    charger.step(0.25)
    assert microamperes(charger) == pytest.approx(1000)


@pytest.mark.spec("C-157")
def test_a_new_mode_starts_from_the_present_value_of_what_it_holds(running):
    running.write(Parameter.CURRENT_SETPOINT, 1000)
    running.write(Parameter.VOLTAGE_SETPOINT, 30000)
    running.write(Parameter.MODE, 4)
    running.step(0.25)
    assert microamperes(running) == pytest.approx((2000 + 1000) / 2, abs=1)


def test_a_ramp_is_a_straight_line_and_stays_at_its_end():
    ramp = Ramp(start=100.0, end=200.0, begin=50, time=100)
    assert [ramp.at(tick) for tick in (50, 55, 60, 99)] == [100.0, 150.0, 200.0, 200.0]


def test_once_off_the_voltage_dies_away_without_a_current(running):
    running.revoke(ReleaseSource.CANOPEN)
    running.step(0.1)
    assert running.charging.output.voltage == pytest.approx(20000 / 2.718282, rel=1e-4)
    assert running.charging.output.current == 0
    assert running.charging.resistance == 0
    running.step(2.0)
    assert running.charging.output.voltage == 0
