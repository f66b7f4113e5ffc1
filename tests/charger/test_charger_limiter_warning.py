import pytest

from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.types import Quantity


def clear(charger, key):
    message = next(message for message in charger.messages.active if message.key == key)
    charger.clear(message.severity, message.number)


@pytest.mark.spec("C-164")
@pytest.mark.parametrize(
    ("parameters", "limiter"),
    [
        ({"mode": 3, "voltage_setpoint": 20000, "current_setpoint": 500}, "current"),
        ({"mode": 4, "voltage_setpoint": 20000, "current_setpoint": 5000}, "voltage"),
        ({"mode": 3, "voltage_setpoint": 30000, "current_setpoint": 5000}, "power"),
    ],
)
def test_a_limiter_is_warned_of_after_a_second(make, switch_on, active, parameters, limiter):
    charger = make(**parameters)
    switch_on(charger, 1.49)
    assert active(charger) == []
    charger.step(0.02)
    assert active(charger) == [("WARNING", f"limiter_{limiter}")]
    assert charger.charging_active


@pytest.mark.spec("C-164")
def test_no_warning_of_a_limiter_where_it_is_not_wanted(make, switch_on, active):
    charger = make(voltage_setpoint=30000, limiter_warning=0)
    switch_on(charger, 60.0)
    assert active(charger) == []


@pytest.mark.spec("C-164")
def test_a_limiter_that_pauses_is_not_warned_of(make, switch_on, active):
    charger = make(voltage_setpoint=20000, current_setpoint=500)
    switch_on(charger, 1.4)
    charger.write(Parameter.CURRENT_SETPOINT, 5000)
    charger.step(0.1)
    charger.write(Parameter.CURRENT_SETPOINT, 500)
    charger.step(1.0)
    assert active(charger) == []
    charger.step(0.1)
    assert active(charger) == [("WARNING", "limiter_current")]


@pytest.mark.spec("C-164")
def test_the_warning_of_a_limiter_stays_until_it_is_cleared(make, switch_on, active):
    charger = make(voltage_setpoint=30000)
    switch_on(charger, 3.0)
    charger.write(Parameter.VOLTAGE_SETPOINT, 10000)
    charger.step(60.0)
    assert active(charger) == [("WARNING", "limiter_power")]
    clear(charger, "limiter_power")
    assert active(charger) == []


@pytest.mark.spec("C-164")
def test_a_limiter_is_warned_of_while_a_master_trims(make, switch_on, active):
    charger = make(voltage_setpoint=20000, current_setpoint=500)
    switch_on(charger, 0.6)
    for trim in range(7):
        charger.write(Parameter.CURRENT_SETPOINT, 501 + trim)
        charger.step(0.2)
        assert charger.limiter is Quantity.CURRENT
    assert active(charger) == [("WARNING", "limiter_current")]


@pytest.mark.spec("C-164")
def test_a_limit_that_a_ramp_comes_to_is_none_before(make, switch_on, active):
    charger = make(voltage_setpoint=20000, current_setpoint=500, ramp_time=10_000)
    switch_on(charger, 9.9)
    assert charger.limiter is None
    charger.step(1.2)
    assert active(charger) == [("WARNING", "limiter_current")]


@pytest.mark.spec("C-045")
@pytest.mark.parametrize("parameter", [Parameter.VOLTAGE_SETPOINT, Parameter.LIMITER_WARNING])
def test_the_warning_of_a_limiter_is_not_cleared_while_its_bit_is_set(
    make, switch_on, active, parameter
):
    charger = make(voltage_setpoint=30000)
    switch_on(charger, 3.0)
    charger.write(parameter, 29999 if parameter is Parameter.VOLTAGE_SETPOINT else 0)
    charger.step(0.1)
    assert charger.limiter is Quantity.POWER
    clear(charger, "limiter_power")
    assert active(charger) == [("WARNING", "limiter_power")]


@pytest.mark.spec("C-162")
def test_the_limiter_bits_fall_with_the_output(make, switch_on, active):
    charger = make(voltage_setpoint=30000)
    switch_on(charger, 3.0)
    charger.revoke(ReleaseSource.CANOPEN)
    assert charger.limiter is None
    clear(charger, "limiter_power")
    assert active(charger) == []
